//! One bake: scene, options, cache, progress and cancellation in; a shadow file out, in memory or streamed to
//! disk.
//!
//! | file | contents |
//! |---|---|
//! | `estimate.rs` | forecasts time, memory and bytes from a few root blocks |
//! | `output.rs` | writes the levels of a file, and files that replace others when they are complete |
//! | `structure.rs` | builds the quadtree, or another structure, from the columns of a plan |
//! | `run.rs` | distributes root blocks over all threads |

mod estimate;
#[cfg(test)]
mod level_tests;
#[cfg(test)]
mod memory_tests;
mod output;
pub(crate) mod run;
pub(crate) mod structure;

use std::fmt;
use std::io::{Seek, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use adumbra::{FileSettings, LightGrid, ShadowFile, Sun};
use adumbra_files::StagedFile;
use adumbra_scene::Scene;

use crate::cache::{BakeCache, PartCache};
use crate::choose::Choice;
use crate::error::{Error, Result};
use crate::inputs::SceneHashes;
use crate::options::{BakeOptions, Size};
use crate::pages::Pages;
use crate::plan::{Placement, Plan};
use crate::progress::{NEVER, Progress, Report, Watch};
use crate::sink::depths::DepthsSink;
pub use estimate::Estimate;
pub(crate) use output::{file_writer, stage, stored_grid, write_level};
use structure::{BuiltStructure, build_planned};

/// A bake of a scene: set what it needs, then run it with [`save`](Bake::save), [`write_to`](Bake::write_to)
/// or [`in_memory`](Bake::in_memory). A bake can run more than once.
///
/// It runs on the current rayon pool. Time and memory grow with the scene and with the length of the
/// silhouettes in texels. The same scene and options give the same bytes, whatever the machine, the number of
/// threads, the memory limit or the cache.
///
/// ```no_run
/// use std::sync::atomic::AtomicBool;
///
/// use adumbra::Sun;
/// use adumbra_bake::{Bake, DiskCache};
///
/// let scene = adumbra_scene::load("city.glb".as_ref(), &Default::default())?;
/// let stop = AtomicBool::new(false);
/// let summary = Bake::new(&scene, Sun::from_direction([0.5, 0.8, 0.35])?)
///     .resolution(16_384)
///     .with(|options| options.thickness_world = 0.1)
///     .cache(DiskCache::create("city.cache")?)
///     .on_progress(|progress| eprintln!("{} of {}", progress.done, progress.total))
///     .cancel(&stop)
///     .save("city.adumbra")?;
/// println!("{} bytes, {} levels of detail", summary.bytes, summary.levels);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use = "a bake does nothing until it is run"]
pub struct Bake<'a> {
    scene: &'a Scene,
    options: BakeOptions,
    cache: Option<Arc<dyn BakeCache>>,
    progress: Box<dyn Fn(Progress) + Send + Sync + 'a>,
    cancel: &'a AtomicBool,
}

/// What a bake has written.
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

impl<'a> Bake<'a> {
    /// Creates a bake with default options, and 8192 texels on the longest side.
    pub fn new(scene: &'a Scene, sun: Sun) -> Self {
        Self::with_options(scene, &BakeOptions::new(sun, Size::default()))
    }

    /// Creates a bake with these options.
    pub fn with_options(scene: &'a Scene, options: &BakeOptions) -> Self {
        Self { scene, options: options.clone(), cache: None, progress: Box::new(|_| {}), cancel: &NEVER }
    }

    /// Sets the number of texels on the longest side of the scene as the sun sees it, see
    /// [`Size::Resolution`].
    pub fn resolution(self, texels: u64) -> Self {
        self.with(|options| options.size = Size::Resolution(texels))
    }

    /// Sets the edge length of a voxel in world units instead of the resolution.
    pub fn voxel_size(self, edge_world: f64) -> Self {
        self.with(|options| options.size = Size::VoxelSize(edge_world))
    }

    /// Changes any option.
    pub fn with(mut self, change: impl FnOnce(&mut BakeOptions)) -> Self {
        change(&mut self.options);
        self
    }

    /// Reuses what earlier bakes have put into `cache`, and puts there what this bake makes. After an edit of
    /// the scene, only the root blocks are baked that the edit touches. The bytes of the file are the same
    /// with and without a cache.
    ///
    /// To share a cache between bakes, pass an `Arc` of it. A cache that fails ends the bake; wrap it in a
    /// [`BestEffortCache`](crate::BestEffortCache) to continue without it. Entries stay until they are
    /// removed, see [`DiskCache::prune`](crate::DiskCache::prune) and
    /// [`MemoryCache::remove_unused`](crate::MemoryCache::remove_unused).
    pub fn cache(mut self, cache: impl BakeCache + 'static) -> Self {
        self.cache = Some(Arc::new(cache));
        self
    }

    /// Calls `report` after each root block, in place of an earlier function. Root blocks of all levels
    /// count, those of the coarsest level first. Calls come from several threads at the same time, so `done`
    /// may arrive out of order.
    pub fn on_progress(mut self, report: impl Fn(Progress) + Send + Sync + 'a) -> Self {
        self.progress = Box::new(report);
        self
    }

    /// Ends the bake with [`Error::Interrupted`] soon after `flag` becomes true. The flag is read before each
    /// root block and before each bundle that is written.
    pub fn cancel(mut self, flag: &'a AtomicBool) -> Self {
        self.cancel = flag;
        self
    }

    /// Sets progress and cancellation from a [`Watch`].
    pub fn watch(self, watch: Watch<'a>) -> Self {
        self.on_progress(watch.progress).cancel(watch.cancel)
    }

    /// Bakes into a file at `path`. The file is streamed to a temporary file beside `path`, which replaces an
    /// existing file when it is complete. What exceeds a memory limit goes to the folder of `path`, unless
    /// the options name another one.
    ///
    /// # Errors
    /// Returns the errors of [`Bake::in_memory`], and [`Error::Io`] with the path of the file if it cannot be
    /// written. An existing file is unchanged then.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<BakeSummary> {
        let (staged, summary) = self.stage(path.as_ref())?;
        StagedFile::place([staged])?;
        Ok(summary)
    }

    /// Bakes into a file that replaces the one at `path` when it is placed, so that a caller can still refuse
    /// the result.
    ///
    /// # Errors
    /// Returns the errors of [`Bake::save`].
    #[doc(hidden)]
    pub fn stage(&self, path: &Path) -> Result<(StagedFile, BakeSummary)> {
        let options = self.options.spilling_beside(path);
        stage(path, |out| self.write_with(&options, out))
    }

    /// Bakes into `out`, from its position on. The file is never whole in memory. What exceeds a memory limit
    /// goes to the system's folder for temporary files, unless the options name another one.
    ///
    /// # Errors
    /// Returns the errors of [`Bake::in_memory`], and [`Error::Output`] with those of `out`. `out` holds a
    /// part of the file then.
    pub fn write_to(&self, out: impl Write + Seek) -> Result<BakeSummary> {
        self.write_with(&self.options, out)
    }

    /// Bakes a file in memory.
    ///
    /// # Errors
    /// - [`Error::Range`], [`Error::Resolution`] or [`Error::File`]: an option is out of range, or the grid
    ///   would be too large.
    /// - [`Error::MemoryLimit`]: scene, tables or the result do not fit the memory limit.
    /// - [`Error::TooManyWords`]: the result is larger than its addresses can reach.
    /// - [`Error::Spill`]: what exceeds the memory limit cannot be written to disk.
    /// - [`Error::Io`]: the cache failed.
    /// - [`Error::Interrupted`]: the caller cancelled.
    pub fn in_memory(&self) -> Result<ShadowFile> {
        self.in_memory_with_report().map(|(file, _)| file)
    }

    /// Bakes a file in memory, and returns the statistics of the bake as well. See [`Bake::in_memory`].
    ///
    /// # Errors
    /// Returns the errors of [`Bake::in_memory`].
    pub fn in_memory_with_report(&self) -> Result<(ShadowFile, Report)> {
        let choice = Choice::new(self.scene, &self.options, self.cancel)?;
        let coarsest = choice.coarsest(self.scene)?;
        let settings = choice.settings(&coarsest);
        let mut levels = Vec::with_capacity(choice.levels.len());
        let report = self.each_level(&self.options, &choice, coarsest, |level, pages| {
            levels.push((stored_grid(choice.levels[level].grid, self.options.region, level), pages.tree()?));
            Ok(())
        })?;
        let Some((grid, tree)) = levels.pop() else { unreachable!("there is at least one level") };
        Ok((ShadowFile::new(grid, settings, tree).with_coarser(levels.into_iter().rev()), report))
    }

    /// Forecasts time, memory and file size from a few root blocks. The forecast reports no progress and uses
    /// no cache.
    ///
    /// # Errors
    /// Returns the errors of [`Bake::in_memory`] but for those of the cache. The memory limit applies to the
    /// forecast itself, not to the bake that it predicts.
    pub fn estimate(&self) -> Result<Estimate> {
        estimate::estimate(self.scene, &self.options, self.cancel)
    }

    fn write_with(&self, options: &BakeOptions, out: impl Write + Seek) -> Result<BakeSummary> {
        let choice = Choice::new(self.scene, options, self.cancel)?;
        let coarsest = choice.coarsest(self.scene)?;
        let settings = choice.settings(&coarsest);
        let grids: Vec<LightGrid> = choice.levels.iter().map(|level| level.grid).collect();
        let mut writer = file_writer(out, settings, &grids, options.encoding)?;
        let report = self.each_level(options, &choice, coarsest, |level, pages| {
            write_level(&mut writer, pages, grids[level].size, options.encoding, self.cancel)
        })?;
        let bytes = writer.finish().map_err(Error::Output)?;
        Ok(BakeSummary { grid: grids[0], settings, levels: grids.len() as u32, bytes, report })
    }

    /// Bakes the pages of each level, the coarsest first, and passes them to `take`. `coarsest` is the plan
    /// of the coarsest level.
    fn each_level<'s>(
        &'s self,
        options: &BakeOptions,
        choice: &Choice,
        coarsest: Plan<'s>,
        mut take: impl FnMut(usize, Pages) -> Result<()>,
    ) -> Result<Report> {
        let hashes = self.cache.as_ref().map(|_| SceneHashes::new(self.scene));
        let cache = self.cache.as_ref().zip(hashes.as_ref());
        let mut report = Report::default();
        let mut coarsest = Some(coarsest);
        for level in (0..choice.levels.len()).rev() {
            let plan = coarsest.take().map_or_else(|| choice.plan(self.scene, level), Ok)?;
            let built = self.level(&plan, options, choice, level, cache)?;
            // Linking needs no triangles.
            drop(plan);
            report = report.with(&built.report);
            take(level, built.made)?;
        }
        Ok(report)
    }

    /// Bakes the pages of a level.
    fn level(
        &self,
        plan: &Plan<'_>,
        options: &BakeOptions,
        choice: &Choice,
        level: usize,
        cache: Option<(&Arc<dyn BakeCache>, &SceneHashes)>,
    ) -> Result<BuiltStructure<Pages>> {
        let before: usize = choice.levels[level + 1..].iter().map(Placement::root_block_count).sum();
        let total: usize = choice.levels.iter().map(Placement::root_block_count).sum();
        let progress = |p: Progress| (self.progress)(Progress { done: before + p.done, total, ..p });
        let (size, root_level) = (plan.root_blocks.grid.size, plan.root_blocks.root_level);
        let mut sink = DepthsSink::new(size, root_level, true, &plan.spill);
        if let Some((cache, hashes)) = cache {
            let parts = choice.levels[level].parts();
            let numbers: Vec<usize> = (0..parts.count()).collect();
            let keys = hashes.keys(plan, options.builder, &numbers, |part| parts.root_blocks(part));
            let part_cache = PartCache::new(cache, parts, numbers.into_iter().zip(keys));
            sink = sink.with_cache(part_cache.within(plan.room_for_entries()));
        }
        let reused_root_blocks = sink.found_root_blocks();
        let mut built = build_planned(plan, options, Watch::new(&progress, self.cancel), |_| sink)?;
        built.report.reused_root_blocks = reused_root_blocks;
        Ok(built)
    }
}

impl fmt::Debug for Bake<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bake")
            .field("options", &self.options)
            .field("cache", &self.cache)
            .finish_non_exhaustive()
    }
}
