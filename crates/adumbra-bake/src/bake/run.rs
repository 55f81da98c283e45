//! Distributes root blocks over all threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::error::{Error, Result};
use crate::fast::descent::{self, DescentBuffers};
use crate::options::ColumnBuilder;
use crate::plain::{self, PlainBuffers};
use crate::plan::Plan;
use crate::sink::Structure;
use crate::tally::Tally;

/// Root blocks, handed out to workers until none is left or one fails.
pub(crate) struct Run<'a, 's> {
    pub(crate) plan: &'a Plan<'s>,
    /// Numbers of the root blocks.
    pub(crate) root_blocks: &'a [usize],
    pub(crate) cancel: &'a AtomicBool,
    /// Whether memory for [`Structure::finish`] stays free, because that follows.
    pub(crate) keeps_room_to_finish: bool,
}

impl Run<'_, '_> {
    /// Builds each root block into `sink`; blocks are returned in order.
    pub(crate) fn each_block<S: Structure>(
        &self,
        builder: ColumnBuilder,
        sink: &S,
        tally: &Tally<'_, '_>,
    ) -> Result<Vec<S::Block>> {
        let root_blocks = &self.plan.root_blocks;
        match builder {
            ColumnBuilder::Fast => {
                self.each_root_block(sink, tally, |worker: &mut DescentBuffers, root_block| {
                    worker.drawn_texels = 0;
                    let block = descent::build_root(root_blocks, root_block, sink, worker, self.cancel)?;
                    tally.drew(worker.drawn_texels);
                    Ok(block)
                })
            }
            ColumnBuilder::Plain => {
                self.each_root_block(sink, tally, |worker: &mut PlainBuffers, root_block| {
                    let rect = root_blocks.rect(root_block);
                    tally.drew(u64::from(rect.width) * u64::from(rect.height));
                    Ok(plain::build_root(root_blocks, root_block, sink, worker))
                })
            }
        }
    }

    /// Returns all root blocks in order: those that the sink knows, and the others from `build`. Every worker
    /// has its own `W`.
    fn each_root_block<W: Default, S: Structure>(
        &self,
        sink: &S,
        tally: &Tally<'_, '_>,
        build: impl Fn(&mut W, usize) -> Result<S::Block> + Sync,
    ) -> Result<Vec<S::Block>> {
        let finished_block = |worker: &mut W, root_block| {
            if self.cancel.load(Ordering::Relaxed) {
                return Err(Error::Interrupted);
            }
            let block = match sink.known(root_block) {
                Some(known) => known,
                None => sink.taken(root_block, build(worker, root_block)?),
            };
            sink.check_room()?;
            let finish_bytes = if self.keeps_room_to_finish { sink.finish_bytes() } else { 0 };
            self.plan.limit_pages_while_building(sink.memory_bytes(), finish_bytes);
            sink.make_room();
            tally.finished_root_block(S::SO_FAR, sink.memory_bytes(), sink.result_bytes())?;
            Ok(block)
        };
        let results: Vec<Mutex<Option<S::Block>>> =
            self.root_blocks.iter().map(|_| Mutex::default()).collect();
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
                        match finished_block(&mut worker, root_block) {
                            Ok(block) => *lock(slot) = Some(block),
                            Err(error) => {
                                next_root_block.store(results.len(), Ordering::Relaxed);
                                lock(&failure).get_or_insert(error);
                                break;
                            }
                        }
                    }
                });
            }
        });
        if let Some(error) = failure.into_inner().unwrap_or_else(|e| e.into_inner()) {
            return Err(error);
        }
        let all = results.into_iter().map(|slot| slot.into_inner().unwrap_or_else(|e| e.into_inner()));
        all.collect::<Option<_>>().ok_or(Error::Interrupted)
    }
}

fn lock<T>(slot: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    slot.lock().unwrap_or_else(|e| e.into_inner())
}
