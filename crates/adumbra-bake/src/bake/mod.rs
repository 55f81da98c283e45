//! The bake.

#[cfg(test)]
mod level_tests;
#[cfg(test)]
mod memory_tests;
pub(crate) mod run;

use std::io::{self, ErrorKind, Seek, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use adumbra::file::{CommonSection, FileWriter, LEVEL_STEP, StoredBundle};
use adumbra::layout::depths::SharedRanges;
use adumbra::layout::depths::page::{BUNDLE_PAGES, Page, page_dims};
use adumbra::{Encoding, FileSettings, FormatError, LightGrid, Region, ShadowFile};
use adumbra_scene::Scene;

use crate::cache::{BakeCache, PartCache, PartGrid};
use crate::choose::{self, Choice};
use crate::error::{Error, Result};
use crate::inputs::SceneHashes;
use crate::options::BakeOptions;
use crate::pages::Pages;
use crate::plan::{Placement, Plan};
use crate::progress::{Progress, Report, Watch};
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

/// A finished bake whose file has been written.
#[derive(Clone, Debug)]
pub struct BakeSummary {
    /// Placement of the finest level's voxels in the world.
    pub grid: LightGrid,
    /// Settings of the bake, as the file has them.
    pub settings: FileSettings,
    /// Number of levels of detail.
    pub levels: u32,
    /// Length of the file in bytes.
    pub bytes: u64,
    /// Statistics of the bake.
    pub report: Report,
}

/// Bakes `scene` into a file in memory.
///
/// Progress is reported from worker threads after each root block, and the cancel flag is read before each. Runs on the
/// current rayon pool. Time and memory grow with the scene and with the length of the silhouettes in texels.
///
/// # Errors
/// Returns an error if an option is out of range, or if a scene, tables or a result do not fit `max_memory_bytes`.
/// Returns [`Error::Spill`] if data that does not fit into memory cannot be written to disk, and
/// [`Error::Interrupted`] if the caller cancels.
pub fn bake(scene: &Scene, options: &BakeOptions, watch: Watch<'_>) -> Result<Bake> {
    bake_in_memory(scene, options, None, watch)
}

/// Bakes `scene` into a file in memory as [`bake`] does, with what `cache` has of earlier bakes. See
/// [`bake_with_cache`].
///
/// # Errors
/// Returns the errors of [`bake`], and [`Error::Io`] with those of `cache`.
pub fn bake_again(
    scene: &Scene,
    options: &BakeOptions,
    cache: &Arc<dyn BakeCache>,
    watch: Watch<'_>,
) -> Result<Bake> {
    bake_in_memory(scene, options, Some(cache), watch)
}

fn bake_in_memory(
    scene: &Scene,
    options: &BakeOptions,
    cache: Option<&Arc<dyn BakeCache>>,
    watch: Watch<'_>,
) -> Result<Bake> {
    let hashes = cache.map(|_| SceneHashes::new(scene));
    let cache = cache.zip(hashes.as_ref());
    let choice = Choice::new(scene, options, watch.cancel)?;
    let mut levels = Vec::with_capacity(choice.levels.len());
    let mut report = Report::default();
    let mut settings = None;
    for level in (0..choice.levels.len()).rev() {
        let plan = choice.plan(scene, level)?;
        let built = build_level(&plan, options, &choice, level, cache, watch)?;
        report = report.with(&built.report);
        settings = Some(built.settings);
        levels.push((stored_grid(built.grid, options.region, level), built.made.tree()?));
    }
    match (levels.pop(), settings) {
        (Some((grid, tree)), Some(settings)) => {
            let file = ShadowFile::new(grid, settings, tree).with_coarser(levels.into_iter().rev());
            Ok(Bake { file, report })
        }
        _ => unreachable!("there is at least one level"),
    }
}

/// Bakes `scene` into `out`, from its position on. The file is never whole in memory. See [`bake`].
///
/// # Errors
/// Returns the errors of [`bake`], and [`Error::Output`] with those of `out`.
pub fn bake_to(
    scene: &Scene,
    options: &BakeOptions,
    watch: Watch<'_>,
    out: impl Write + Seek,
) -> Result<BakeSummary> {
    bake_file(scene, options, None, watch, out)
}

/// Bakes `scene` into `out` as [`bake_to`] does, to the same bytes, but takes from `cache` what an earlier bake has
/// made of the same surfaces in the same place, and keeps there what it makes. An edit of a scene bakes the root blocks
/// that the edit touches, before it and after it.
///
/// # Errors
/// Returns the errors of [`bake_to`], and [`Error::Io`] with those of `cache`.
pub fn bake_with_cache(
    scene: &Scene,
    options: &BakeOptions,
    cache: &Arc<dyn BakeCache>,
    watch: Watch<'_>,
    out: impl Write + Seek,
) -> Result<BakeSummary> {
    bake_file(scene, options, Some(cache), watch, out)
}

fn bake_file(
    scene: &Scene,
    options: &BakeOptions,
    cache: Option<&Arc<dyn BakeCache>>,
    watch: Watch<'_>,
    out: impl Write + Seek,
) -> Result<BakeSummary> {
    let choice = Choice::new(scene, options, watch.cancel)?;
    let plan_of = |level: usize| choice.plan(scene, level);
    let plan = plan_of(choice.levels.len() - 1)?;
    // Only the resolution differs from level to level.
    let settings = FileSettings { resolution: choice.levels[0].resolution, ..plan.settings };
    let grids: Vec<LightGrid> = choice.levels.iter().map(|level| level.grid).collect();
    let mut writer = file_writer(out, settings, &grids, options.encoding)?;
    let mut report = Report::default();
    let mut coarsest = Some(plan);
    let hashes = cache.map(|_| SceneHashes::new(scene));
    let cache = cache.zip(hashes.as_ref());
    for level in (0..grids.len()).rev() {
        let plan = coarsest.take().map_or_else(|| plan_of(level), Ok)?;
        let built = build_level(&plan, options, &choice, level, cache, watch)?;
        // Linking needs no triangles.
        drop(plan);
        report = report.with(&built.report);
        write_level(&mut writer, built.made, grids[level].size, options.encoding, watch.cancel)?;
    }
    let bytes = writer.finish().map_err(Error::Output)?;
    Ok(BakeSummary { grid: grids[0], settings, levels: grids.len() as u32, bytes, report })
}

/// Returns a level's grid as the file has it: that of a region is relative to the region's origin.
pub(crate) fn stored_grid(grid: LightGrid, region: Option<Region>, level: usize) -> LightGrid {
    region.map_or(grid, |region| region.relative(grid, LEVEL_STEP.pow(level as u32)))
}

/// Begins a file with grids that lie in the world, the finest first.
pub(crate) fn file_writer<W: Write + Seek>(
    out: W,
    settings: FileSettings,
    grids: &[LightGrid],
    encoding: Encoding,
) -> Result<FileWriter<W>> {
    let stored = |(level, grid): (usize, &LightGrid)| stored_grid(*grid, settings.region, level);
    let stored: Vec<LightGrid> = grids.iter().enumerate().map(stored).collect();
    FileWriter::new(out, settings, &stored, encoding).map_err(Error::Output)
}

/// Links the pages of a level, and writes them.
pub(crate) fn write_level(
    writer: &mut FileWriter<impl Write + Seek>,
    pages: Pages,
    size: [u32; 3],
    encoding: Encoding,
    cancel: &AtomicBool,
) -> Result<()> {
    let mut linked = pages.link()?;
    let (words, shapes) = linked.take_common();
    let common = CommonSection::new(words, || shapes, encoding).map_err(invalid)?;
    writer.common(&common).map_err(Error::Output)?;
    let dims = page_dims(size);
    let ranges = SharedRanges::new(common.words());
    let stored = |at, pages: &[Page<'_>; BUNDLE_PAGES]| {
        ranges.with(|ranges| StoredBundle::new(at, dims, pages, ranges, &common))
    };
    linked.for_each_bundle(stored, |_, bundle| {
        if cancel.load(Ordering::Relaxed) {
            return Err(Error::Interrupted);
        }
        writer.bundle(&bundle.map_err(invalid)?).map_err(Error::Output)
    })
}

/// Returns the error for pages that cannot be written.
fn invalid(fault: FormatError) -> Error {
    Error::Output(io::Error::new(ErrorKind::InvalidData, fault))
}

/// Bakes the pages of a level. Progress counts the root blocks of all levels, the coarsest first.
fn build_level(
    plan: &Plan<'_>,
    options: &BakeOptions,
    choice: &Choice,
    level: usize,
    cache: Option<(&Arc<dyn BakeCache>, &SceneHashes)>,
    watch: Watch<'_>,
) -> Result<BuiltStructure<Pages>> {
    let blocks = |level: &Placement| level.blocks()[..2].iter().map(|&n| n as usize).product::<usize>();
    let before: usize = choice.levels[level + 1..].iter().map(blocks).sum();
    let total: usize = choice.levels.iter().map(blocks).sum();
    let progress = |p: Progress| {
        (watch.progress)(Progress { done: before + p.done, total, ..p });
    };
    let (size, root_level) = (plan.root_blocks.grid.size, plan.root_blocks.root_level);
    let mut sink = DepthsSink::new(size, root_level, true, &plan.spill);
    if let Some((cache, hashes)) = cache {
        let parts = PartGrid::new(size, root_level);
        let numbers: Vec<usize> = (0..parts.count()).collect();
        let keys = hashes.keys(plan, options.builder, &parts, &numbers);
        let part_cache = PartCache::new(cache, parts, numbers.into_iter().zip(keys));
        sink = sink.with_cache(part_cache.within(plan.room_for_entries()));
    }
    let reused_root_blocks = sink.found_root_blocks();
    let mut built = build_planned(plan, options, Watch::new(&progress, watch.cancel), |_| sink)?;
    built.report.reused_root_blocks = reused_root_blocks;
    Ok(built)
}

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
    let finished_root_block = || {
        sink.check_room()?;
        plan.limit_pages_while_building(sink.memory_bytes(), sink.finish_bytes());
        sink.make_room();
        tally.finished_root_block(S::SO_FAR, sink.memory_bytes(), sink.result_bytes())
    };
    let run = Run {
        plan,
        root_blocks: &root_blocks,
        cancel: watch.cancel,
        finished_root_block: &finished_root_block,
    };
    let blocks = run.each_block(options.builder, &sink, &tally)?;
    let held_bytes = sink.memory_bytes() + sink.finish_bytes();
    plan.limit_pages(plan.scene_bytes + held_bytes);
    sink.make_room();
    tally.check_end(S::FINISHING, held_bytes)?;
    let made = sink.finish(blocks);
    plan.paged_bytes()?;
    Ok(BuiltStructure { grid: plan.root_blocks.grid, settings: plan.settings, made, report: tally.report() })
}
