//! The bake: scene and sun in, graph out. Light-aligned, root block by root block on all cores; the depth image is never
//! whole, and [`Builder::Fast`] never draws most of it.
//!
//! Source: Sintorn et al. 2014 for the light-aligned voxel DAG; the specification's §3 for what a column allows. The
//! result does not depend on the number of threads, the order of blocks or of triangles, or the memory limit.

#[cfg(test)]
mod agreement;
mod block;
mod both;
pub(crate) mod capture;
pub(crate) mod casters;
pub(crate) mod columns;
mod descent;
mod early;
mod estimate;
#[cfg(test)]
mod fuzz;
mod gather;
pub(crate) mod graph_sink;
pub(crate) mod hierarchy;
mod judge;
mod leaf;
mod masked;
pub(crate) mod options;
mod outline;
mod packed;
mod plain;
mod plan;
pub(crate) mod project;
#[cfg(test)]
mod reference;
pub(crate) mod sink;
pub(crate) mod surface;
mod switches;
mod tally;
mod texel_mask;
mod tile;

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

pub use both::{BakedBoth, bake_both};
use descent::DescentBuffers;
use early::EarlySink;
pub use estimate::{Estimate, estimate};
use graph_sink::GraphSink;
pub use hierarchy::{BakedHierarchy, bake_hierarchy};
pub use options::{
    Builder, DEFAULT_SWITCH_WITHIN, MAX_RESOLUTION, MAX_SWITCH_WITHIN, MIN_RESOLUTION, Options, Preset, Size,
};
pub use packed::{BakedPacked, bake_packed};
use plain::PlainBuffers;
use plan::Plan;
use sink::BlockSink;
use tally::Tally;

use crate::dag::store::{NodeState, NodeStore};
use crate::dag::{Dag, PagedDag};
use crate::error::{Error, Result};
use crate::light::LightGrid;
use crate::scene::Scene;
use crate::settings::Settings;

/// A finished bake.
#[derive(Debug)]
pub struct Baked {
    /// Where the grid lies.
    pub grid: LightGrid,
    /// What was asked for.
    pub settings: Settings,
    /// The answers.
    pub dag: Dag,
    /// How it went.
    pub report: Report,
}

/// How a bake went. Varies from run to run; never written into the file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Report {
    /// Wall seconds.
    pub seconds: f64,
    /// Tiles drawn.
    pub tiles: usize,
    /// Threads that drew them.
    pub threads: usize,
    /// Texels that were looked at one by one.
    pub drawn_texels: u64,
    /// Largest sum of the bytes that the bake accounted for: scene, tiles, graph.
    pub accounted_bytes: u64,
    /// Bytes that a memory limit sent to disk, as often as they were written.
    pub spilled_bytes: u64,
}

/// Where a bake stands.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Tiles done.
    pub done_tiles: usize,
    /// Tiles in all.
    pub total_tiles: usize,
    /// Texels a tile.
    pub texels_per_tile: u64,
    /// Bytes of the graph so far.
    pub graph_bytes: u64,
}

/// Bakes `scene`.
///
/// `progress` is called from worker threads after each root block; `cancel` is looked at before each. Runs on the current
/// rayon pool. Cost of [`Builder::Fast`]: time and memory grow with the scene and with the length of the silhouettes in
/// texels; of [`Builder::Plain`]: time grows with texels times layers.
///
/// # Errors
/// An option out of range, a scene, tables or a result that does not fit `max_memory_bytes`, [`Error::Io`] where what has
/// no room cannot be written to disk, or [`Error::Interrupted`].
pub fn bake(
    scene: &Scene,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<Baked> {
    let start = Instant::now();
    let plan = Plan::new(scene, options)?;
    let tally = Tally::new(&plan, start, progress);
    let (store, columns) = build_graph(&plan, &tally, options.builder, cancel)?;
    let dag = finish_graph(store, &plan, &tally, &columns, 0)?;
    Ok(Baked { grid: plan.grid, settings: plan.settings, dag, report: tally.report() })
}

/// The nodes of all root blocks, and the roots of each, nearest first.
fn build_graph(
    plan: &Plan<'_>,
    tally: &Tally<'_, '_>,
    builder: Builder,
    cancel: &AtomicBool,
) -> Result<(NodeStore, Vec<Vec<NodeState>>)> {
    let store = NodeStore::new(plan.spill.as_ref());
    let finished_tile = || -> Result<()> {
        check_room(&store)?;
        tally.finished_tile("the graph so far", store.memory_bytes(), store.graph_bytes())
    };
    let run = Run { plan, cancel, finished_tile: &finished_tile };
    let columns = match builder {
        Builder::Fast => {
            let sink = GraphSink::new(&store, plan.grid.size[2]);
            let blocks = run.each_block(&sink, tally)?;
            blocks.iter().map(|block| sink.roots(block, plan.root_level, plan.top_dims[2])).collect()
        }
        Builder::Plain => run.each_tile(|worker: &mut PlainBuffers, tile| {
            let rect = plan.tile_rect(tile);
            tally.drew(u64::from(rect.width) * u64::from(rect.height));
            Ok(plain::build_root(plan, tile, &store, worker))
        })?,
    };
    Ok((store, columns))
}

/// That the graph has no more words than can be numbered.
fn check_room(store: &NodeStore) -> Result<()> {
    if store.is_full() { Err(Error::TooManyWords { what: "the graph" }) } else { Ok(()) }
}

/// The graph whose roots these are, each tile's nearest first; `beside_bytes` are held beside it.
fn finish_graph(
    store: NodeStore,
    plan: &Plan<'_>,
    tally: &Tally<'_, '_>,
    columns: &[Vec<NodeState>],
    beside_bytes: u64,
) -> Result<Dag> {
    let (numbered, kept_bytes) = number_graph(store, plan, tally, columns, beside_bytes)?;
    if plan.spill.is_some() {
        tally.check_end("the finished graph", beside_bytes + kept_bytes + numbered.graph_bytes())?;
    }
    let dag = numbered.into_dag();
    plan.paged_bytes()?;
    Ok(dag)
}

/// The same, still in pages where there is a limit; and the bytes of what is freed by then, which allocators rarely give back.
fn number_graph(
    store: NodeStore,
    plan: &Plan<'_>,
    tally: &Tally<'_, '_>,
    columns: &[Vec<NodeState>],
    beside_bytes: u64,
) -> Result<(PagedDag, u64)> {
    let kept_bytes = store.memory_bytes();
    let copy_bytes = if plan.spill.is_some() { 0 } else { store.graph_bytes() };
    tally.check_end("numbering the graph", beside_bytes + kept_bytes + store.numbers_bytes() + copy_bytes)?;
    let top = top_grid(columns, plan.top_dims[2]);
    let numbered = store.number(plan.grid.size, plan.root_level, plan.top_dims, &top);
    plan.paged_bytes()?;
    Ok((numbered, kept_bytes))
}

/// Roots of each tile, nearest first, as one grid: x fastest, then y, then z.
fn top_grid(columns: &[Vec<NodeState>], depth: u32) -> Vec<NodeState> {
    (0..depth as usize).flat_map(|z| columns.iter().map(move |roots| roots[z])).collect()
}

/// Root blocks handed out to workers until none is left or something fails.
struct Run<'a, 's> {
    plan: &'a Plan<'s>,
    cancel: &'a AtomicBool,
    finished_tile: &'a (dyn Fn() -> Result<()> + Sync),
}

impl Run<'_, '_> {
    /// Each root block by descent into `sink`, in order.
    fn each_block<S: BlockSink>(&self, sink: &S, tally: &Tally<'_, '_>) -> Result<Vec<S::Block>> {
        let sink = EarlySink { early: self.plan.early(), sink };
        self.each_tile(|worker: &mut DescentBuffers, tile| {
            worker.drawn_texels = 0;
            let block = descent::build_root(self.plan, tile, &sink, worker, self.cancel);
            tally.drew(worker.drawn_texels);
            block
        })
    }

    /// The result of each tile, in order; every worker has a `W` of its own.
    fn each_tile<W: Default, T: Send>(
        &self,
        build: impl Fn(&mut W, usize) -> Result<T> + Sync,
    ) -> Result<Vec<T>> {
        let tiles = self.plan.tiles();
        let results: Vec<Mutex<Option<T>>> = (0..tiles).map(|_| Mutex::default()).collect();
        let next_tile = AtomicUsize::new(0);
        let failure = Mutex::new(None);
        rayon::scope(|scope| {
            for _ in 0..self.plan.workers {
                scope.spawn(|_| {
                    let mut worker = W::default();
                    loop {
                        let tile = next_tile.fetch_add(1, Ordering::Relaxed);
                        let Some(slot) = results.get(tile) else { break };
                        let outcome = if self.cancel.load(Ordering::Relaxed) {
                            Err(Error::Interrupted)
                        } else {
                            build(&mut worker, tile).and_then(|built| {
                                *lock(slot) = Some(built);
                                (self.finished_tile)()
                            })
                        };
                        if let Err(error) = outcome {
                            next_tile.store(tiles, Ordering::Relaxed);
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
