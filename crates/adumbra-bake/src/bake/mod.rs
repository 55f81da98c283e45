//! The bake.

#[cfg(test)]
mod memory_tests;
mod run;

use std::time::Instant;

use adumbra::{FileSettings, LightGrid, ShadowFile};
use adumbra_scene::Scene;

use crate::choose;
use crate::error::Result;
use crate::options::BakeOptions;
use crate::plan::Plan;
use crate::progress::{Report, Watch};
use crate::sink::Structure;
use crate::sink::depths::DepthsSink;
use crate::tally::Tally;
use run::Run;

/// A finished bake.
#[derive(Debug)]
pub struct Bake {
    /// The file that an engine loads.
    pub file: ShadowFile,
    /// Statistics of the bake.
    pub report: Report,
}

/// Bakes `scene`.
///
/// Progress is reported from worker threads after each root block, and the cancel flag is read before each. Runs on the
/// current rayon pool. Time and memory grow with the scene and with the length of the silhouettes in texels.
///
/// # Errors
/// Returns an error if an option is out of range, or if a scene, tables or a result do not fit `max_memory_bytes`.
/// Returns [`Error::Spill`](crate::Error::Spill) if data that does not fit into memory cannot be written to disk, and
/// [`Error::Interrupted`](crate::Error::Interrupted) if the caller cancels.
pub fn bake(scene: &Scene, options: &BakeOptions, watch: Watch<'_>) -> Result<Bake> {
    let sink = |plan: &Plan<'_>| DepthsSink::new(plan.tiles.root_level, true, plan.spill.as_ref());
    let Built { grid, settings, made, report } = build_planned(scene, options, watch, sink)?;
    Ok(Bake { file: ShadowFile::new(grid, settings, made), report })
}

/// What was built from a scene.
#[derive(Debug)]
pub struct Built<T> {
    /// Placement of the voxels in the world.
    pub grid: LightGrid,
    /// Settings of the bake.
    pub settings: FileSettings,
    /// What the structure made of its blocks.
    pub made: T,
    /// Statistics of the bake.
    pub report: Report,
}

/// Builds a structure from the columns of `scene`, as [`bake`] builds a file. `sink` creates it for a grid of this many
/// voxels along x, y, z, and root blocks of this level. The structure is in memory: nothing of it goes to disk.
///
/// # Errors
/// Returns the errors of [`bake`].
pub fn build<S: Structure>(
    scene: &Scene,
    options: &BakeOptions,
    watch: Watch<'_>,
    sink: impl FnOnce([u32; 3], u32) -> S,
) -> Result<Built<S::Made>> {
    build_planned(scene, options, watch, |plan| sink(plan.tiles.grid.size, plan.tiles.root_level))
}

/// Builds the structure that `sink` creates for a plan. See [`build`].
pub(crate) fn build_planned<S: Structure>(
    scene: &Scene,
    options: &BakeOptions,
    watch: Watch<'_>,
    sink: impl FnOnce(&Plan<'_>) -> S,
) -> Result<Built<S::Made>> {
    let start = Instant::now();
    let plan = choose::plan(scene, options)?;
    let tally = Tally::new(&plan, start, watch.progress);
    let sink = sink(&plan);
    let finished_tile = || {
        sink.check_room()?;
        tally.finished_tile(S::SO_FAR, sink.memory_bytes(), sink.result_bytes())
    };
    let run = Run { plan: &plan, cancel: watch.cancel, finished_tile: &finished_tile };
    let blocks = run.each_block(options.builder, &sink, &tally)?;
    tally.check_end(S::FINISHING, sink.memory_bytes() + sink.finish_bytes())?;
    let made = sink.finish(plan.tiles.grid.size, plan.tiles.root_level, blocks);
    plan.paged_bytes()?;
    Ok(Built { grid: plan.tiles.grid, settings: plan.settings, made, report: tally.report() })
}
