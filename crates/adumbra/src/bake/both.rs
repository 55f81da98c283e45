//! One walk through the scene into both structures, for whoever wants the smaller.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::graph_sink::GraphSink;
use super::plan::Plan;
use super::sink::{BlockColumns, BlockSink};
use super::tally::Tally;
use super::{Options, Progress, Report, Run, check_room, finish_graph};
use crate::dag::Dag;
use crate::dag::store::NodeStore;
use crate::error::Result;
use crate::hierarchy::Hierarchy;
use crate::hierarchy::sink::HierarchySink;
use crate::light::LightGrid;
use crate::scene::Scene;
use crate::settings::Settings;

/// A finished bake, twice.
#[derive(Debug)]
pub struct BakedBoth {
    /// Where the grid lies.
    pub grid: LightGrid,
    /// What was asked for.
    pub settings: Settings,
    /// The answers, as [`super::bake`] gives them.
    pub dag: Dag,
    /// The answers, as [`super::bake_hierarchy`] gives them, merged.
    pub hierarchy: Hierarchy,
    /// How it went.
    pub report: Report,
}

/// Bakes `scene` as [`super::bake`] and [`super::bake_hierarchy`] do, by the fast builder whatever `options` say. Columns are found
/// once; memory is that of both.
///
/// # Errors
/// As [`super::bake`].
pub fn bake_both(
    scene: &Scene,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<BakedBoth> {
    let start = Instant::now();
    let plan = Plan::new(scene, &Options { builder: super::Builder::Fast, ..options.clone() })?;
    let tally = Tally::new(&plan, start, progress);
    let store = NodeStore::new(plan.spill.as_ref());
    let sink = Pair(
        GraphSink::new(&store, plan.grid.size[2]),
        HierarchySink::new(plan.root_level, true, plan.spill.as_ref()),
    );
    let held_bytes = || store.memory_bytes() + sink.1.memory_bytes();
    let finished_tile = || {
        check_room(&store)?;
        sink.1.check_room()?;
        tally.finished_tile("the graph and the hierarchy so far", held_bytes(), store.graph_bytes())
    };
    let run = Run { plan: &plan, cancel, finished_tile: &finished_tile };
    let (runs, blocks): (Vec<_>, Vec<_>) = run.each_block(&sink, &tally)?.into_iter().unzip();
    let kept_bytes = sink.1.memory_bytes();
    tally.check_end("numbering the hierarchy", held_bytes() + sink.1.finish_bytes())?;
    let Pair(graph_sink, hierarchy_sink) = sink;
    let roots = |runs| graph_sink.roots(runs, plan.root_level, plan.top_dims[2]);
    let columns: Vec<_> = runs.iter().map(roots).collect();
    let hierarchy = hierarchy_sink.finish(plan.grid.size, plan.root_level, blocks);
    let dag = finish_graph(store, &plan, &tally, &columns, kept_bytes + hierarchy.bytes())?;
    Ok(BakedBoth { grid: plan.grid, settings: plan.settings, dag, hierarchy, report: tally.report() })
}

/// Two sinks that are told the same.
struct Pair<A, B>(A, B);

impl<A: BlockSink, B: BlockSink> BlockSink for Pair<A, B> {
    type Block = (A::Block, B::Block);

    fn uniform(&self, level: u32, interval: [u32; 2]) -> Self::Block {
        (self.0.uniform(level, interval), self.1.uniform(level, interval))
    }

    fn leaf(&self, columns: &BlockColumns) -> Self::Block {
        (self.0.leaf(columns), self.1.leaf(columns))
    }

    fn join(&self, level: u32, quarters: [Self::Block; 4]) -> Self::Block {
        let [(a0, b0), (a1, b1), (a2, b2), (a3, b3)] = quarters;
        (self.0.join(level, [a0, a1, a2, a3]), self.1.join(level, [b0, b1, b2, b3]))
    }
}
