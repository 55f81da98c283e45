//! Distributes root blocks over all threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::error::{Error, Result};
use crate::fast::descent::{self, DescentBuffers};
use crate::options::Builder;
use crate::plain::{self, PlainBuffers};
use crate::plan::Plan;
use crate::sink::BlockSink;
use crate::sink::limit::LimitSink;
use crate::tally::Tally;

/// Root blocks, handed out to workers until none is left or one fails.
pub(crate) struct Run<'a, 's> {
    pub(crate) plan: &'a Plan<'s>,
    /// Numbers of the root blocks.
    pub(crate) tiles: &'a [usize],
    pub(crate) cancel: &'a AtomicBool,
    pub(crate) finished_tile: &'a (dyn Fn() -> Result<()> + Sync),
}

impl Run<'_, '_> {
    /// Builds each root block into `sink`; blocks are returned in order.
    pub(crate) fn each_block<S: BlockSink>(
        &self,
        builder: Builder,
        sink: &S,
        tally: &Tally<'_, '_>,
    ) -> Result<Vec<S::Block>> {
        let tiles = &self.plan.tiles;
        let limit = self.plan.switch_limit();
        match builder {
            Builder::Fast => {
                let sink = LimitSink { limit, sink };
                self.each_tile(|worker: &mut DescentBuffers, tile| {
                    if let Some(known) = sink.sink.known(tile) {
                        return Ok(known);
                    }
                    worker.drawn_texels = 0;
                    let block = descent::build_root(tiles, tile, &sink, worker, self.cancel)?;
                    tally.drew(worker.drawn_texels);
                    Ok(sink.taken(tile, block))
                })
            }
            Builder::Plain => self.each_tile(|worker: &mut PlainBuffers, tile| {
                if let Some(known) = sink.known(tile) {
                    return Ok(known);
                }
                let rect = tiles.rect(tile);
                tally.drew(u64::from(rect.width) * u64::from(rect.height));
                Ok(sink.taken(tile, plain::build_root(tiles, limit, tile, sink, worker)))
            }),
        }
    }

    /// Returns the result of each root block, in order. Every worker has its own `W`.
    fn each_tile<W: Default, T: Send>(
        &self,
        build: impl Fn(&mut W, usize) -> Result<T> + Sync,
    ) -> Result<Vec<T>> {
        let results: Vec<Mutex<Option<T>>> = self.tiles.iter().map(|_| Mutex::default()).collect();
        let next_tile = AtomicUsize::new(0);
        let failure = Mutex::new(None);
        rayon::scope(|scope| {
            for _ in 0..self.plan.workers {
                scope.spawn(|_| {
                    let mut worker = W::default();
                    loop {
                        let next = next_tile.fetch_add(1, Ordering::Relaxed);
                        let (Some(slot), Some(&tile)) = (results.get(next), self.tiles.get(next)) else {
                            break;
                        };
                        let outcome = if self.cancel.load(Ordering::Relaxed) {
                            Err(Error::Interrupted)
                        } else {
                            build(&mut worker, tile).and_then(|built| {
                                *lock(slot) = Some(built);
                                (self.finished_tile)()
                            })
                        };
                        if let Err(error) = outcome {
                            next_tile.store(results.len(), Ordering::Relaxed);
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
