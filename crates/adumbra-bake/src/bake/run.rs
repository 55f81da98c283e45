//! Distributes root blocks over all threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::error::{Error, Result};
use crate::fast::descent::{self, DescentBuffers};
use crate::options::ColumnBuilder;
use crate::plain::{self, PlainBuffers};
use crate::plan::Plan;
use crate::sink::BlockSink;
use crate::sink::limit::LimitSink;
use crate::tally::Tally;

/// Root blocks, handed out to workers until none is left or one fails.
pub(crate) struct Run<'a, 's> {
    pub(crate) plan: &'a Plan<'s>,
    /// Numbers of the root blocks.
    pub(crate) root_blocks: &'a [usize],
    pub(crate) cancel: &'a AtomicBool,
    pub(crate) finished_root_block: &'a (dyn Fn() -> Result<()> + Sync),
}

impl Run<'_, '_> {
    /// Builds each root block into `sink`; blocks are returned in order.
    pub(crate) fn each_block<S: BlockSink>(
        &self,
        builder: ColumnBuilder,
        sink: &S,
        tally: &Tally<'_, '_>,
    ) -> Result<Vec<S::Block>> {
        let root_blocks = &self.plan.root_blocks;
        let limit = self.plan.switch_limit();
        match builder {
            ColumnBuilder::Fast => {
                let sink = LimitSink { limit, sink };
                self.each_root_block(|worker: &mut DescentBuffers, root_block| {
                    if let Some(known) = sink.known(root_block) {
                        return Ok(known);
                    }
                    worker.drawn_texels = 0;
                    let block = descent::build_root(root_blocks, root_block, &sink, worker, self.cancel)?;
                    tally.drew(worker.drawn_texels);
                    Ok(sink.taken(root_block, block))
                })
            }
            ColumnBuilder::Plain => self.each_root_block(|worker: &mut PlainBuffers, root_block| {
                if let Some(known) = sink.known(root_block) {
                    return Ok(known);
                }
                let rect = root_blocks.rect(root_block);
                tally.drew(u64::from(rect.width) * u64::from(rect.height));
                Ok(sink.taken(root_block, plain::build_root(root_blocks, limit, root_block, sink, worker)))
            }),
        }
    }

    /// Returns the result of each root block, in order. Every worker has its own `W`.
    fn each_root_block<W: Default, T: Send>(
        &self,
        build: impl Fn(&mut W, usize) -> Result<T> + Sync,
    ) -> Result<Vec<T>> {
        let results: Vec<Mutex<Option<T>>> = self.root_blocks.iter().map(|_| Mutex::default()).collect();
        let next_root_block = AtomicUsize::new(0);
        let failure = Mutex::new(None);
        rayon::scope(|scope| {
            for _ in 0..self.plan.workers {
                scope.spawn(|_| {
                    let mut worker = W::default();
                    loop {
                        let next = next_root_block.fetch_add(1, Ordering::Relaxed);
                        let (Some(slot), Some(&root_block)) = (results.get(next), self.root_blocks.get(next))
                        else {
                            break;
                        };
                        let outcome = if self.cancel.load(Ordering::Relaxed) {
                            Err(Error::Interrupted)
                        } else {
                            build(&mut worker, root_block).and_then(|built| {
                                *lock(slot) = Some(built);
                                (self.finished_root_block)()
                            })
                        };
                        if let Err(error) = outcome {
                            next_root_block.store(results.len(), Ordering::Relaxed);
                            lock(&failure).get_or_insert(error);
                            break;
                        }
                    }
                });
            }
        });
        if let Some(error) = failure.into_inner().unwrap_or_else(|e| e.into_inner()) {
            return Err(error);
        }
        let all = results.into_iter().map(|slot| slot.into_inner().unwrap_or_else(|e| e.into_inner()));
        all.collect::<Option<Vec<T>>>().ok_or(Error::Interrupted)
    }
}

fn lock<T>(slot: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    slot.lock().unwrap_or_else(|e| e.into_inner())
}
