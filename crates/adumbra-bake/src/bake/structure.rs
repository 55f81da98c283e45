//! Builds the quadtree, or another structure, from the columns of a plan.

use std::time::Instant;

use adumbra::{FileSettings, LightGrid};
use adumbra_scene::Scene;

use super::run::Run;
use crate::choose;
use crate::error::Result;
use crate::options::BakeOptions;
use crate::plan::Plan;
use crate::progress::{Report, Watch};
use crate::sink::Structure;
use crate::tally::Tally;

/// What was built from a scene.
#[derive(Debug)]
pub struct BuiltStructure<T> {
    /// Placement of the voxels in the world.
    pub grid: LightGrid,
    /// Settings of the bake.
    pub settings: FileSettings,
    /// What the structure made of its blocks.
    pub made: T,
    /// Statistics of the bake.
    pub report: Report,
}

/// Builds a structure from the columns of `scene`, as [`Bake`](crate::Bake) builds a file. `sink` creates it
/// for a grid of this many voxels along x, y, z, and root blocks of this level. The structure is in memory:
/// nothing of it goes to disk.
///
/// # Errors
/// Returns the errors of [`Bake::in_memory`](crate::Bake::in_memory).
pub fn build<S: Structure>(
    scene: &Scene,
    options: &BakeOptions,
    watch: Watch<'_>,
    sink: impl FnOnce([u32; 3], u32) -> S,
) -> Result<BuiltStructure<S::Output>> {
    let plan = choose::plan(scene, options)?;
    build_planned(&plan, options, watch, |plan| sink(plan.root_blocks.grid.size, plan.root_blocks.root_level))
}

/// Builds the structure that `sink` creates for a plan. See [`build`].
pub(crate) fn build_planned<S: Structure>(
    plan: &Plan<'_>,
    options: &BakeOptions,
    watch: Watch<'_>,
    sink: impl FnOnce(&Plan<'_>) -> S,
) -> Result<BuiltStructure<S::Output>> {
    let start = Instant::now();
    let root_blocks: Vec<usize> = (0..plan.root_blocks.count()).collect();
    let tally = Tally::new(plan, root_blocks.len(), start, watch.progress);
    let sink = sink(plan);
    let run = Run { plan, root_blocks: &root_blocks, cancel: watch.cancel, keeps_room_to_finish: true };
    let blocks = run.each_block(options.builder, &sink, &tally)?;
    let held_bytes = sink.memory_bytes() + sink.finish_bytes();
    plan.limit_pages(plan.scene_bytes + held_bytes);
    sink.make_room();
    tally.check_end(S::FINISHING, held_bytes)?;
    let made = sink.finish(blocks);
    plan.paged_bytes()?;
    Ok(BuiltStructure { grid: plan.root_blocks.grid, settings: plan.settings, made, report: tally.report() })
}
