//! The bake that builds depths instead of a graph.

use std::sync::atomic::AtomicBool;

use adumbra::layout::depths::DepthTree;

use super::run::Run;
use crate::error::Result;
use crate::plan::Plan;
use crate::sink::depths::DepthsSink;
use crate::tally::Tally;

/// Builds the quadtree of depths. `merged`: equal shapes are stored once.
pub(crate) fn depths(
    plan: &Plan<'_>,
    tally: &Tally<'_, '_>,
    merged: bool,
    cancel: &AtomicBool,
) -> Result<DepthTree> {
    let sink = DepthsSink::new(plan.tiles.root_level, merged, plan.spill.as_ref());
    let finished_tile = || {
        sink.check_room()?;
        tally.finished_tile("the depths so far", sink.memory_bytes(), sink.shape_bytes())
    };
    let run = Run { plan, cancel, finished_tile: &finished_tile };
    let blocks = run.each_block(&sink, tally)?;
    tally.check_end("numbering the depths", sink.memory_bytes() + sink.finish_bytes())?;
    let depths = sink.finish(plan.tiles.grid.size, plan.tiles.root_level, blocks);
    plan.paged_bytes()?;
    Ok(depths)
}
