//! Makes the file of a plan.

use std::io::{Seek, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use adumbra::layout::depths::DepthTree;
use adumbra::{LightGrid, ShadowFile};
use adumbra_files::StagedFile;

use super::plan::{BakePlan, PlannedPart};
use crate::bake::{BakeSummary, file_writer, stage, stored_grid, write_level};
use crate::cache::{BakeCache, PartCache};
use crate::error::{Error, Result};
use crate::options::BakeOptions;
use crate::pages::Spill;
use crate::plan::Placement;
use crate::progress::{Progress, Report, Watch};
use crate::sink::Structure;
use crate::sink::depths::DepthsSink;

impl BakePlan {
    /// Links the entries of the parts to a file in `out`, from its position on. The bytes are those of a bake
    /// on one machine. The scene is not needed. Of `limits`, the memory limit and the folder for temporary
    /// files count.
    ///
    /// # Errors
    /// Returns [`Error::MissingParts`] if entries are missing or damaged, [`Error::Io`] with the errors of
    /// `cache`, [`Error::Output`] with those of `out`, and the errors of the memory limit.
    pub fn link(
        &self,
        cache: &Arc<dyn BakeCache>,
        limits: &BakeOptions,
        watch: Watch<'_>,
        out: impl Write + Seek,
    ) -> Result<BakeSummary> {
        let start = Instant::now();
        let grids = self.grids();
        let mut writer = file_writer(out, self.settings, &grids, self.encoding)?;
        let mut report = Report { threads: rayon::current_num_threads(), ..Report::default() };
        let total = self.levels.iter().map(Placement::root_block_count).sum();
        for level in (0..grids.len()).rev() {
            if watch.cancel.load(std::sync::atomic::Ordering::Relaxed) {
                return Err(Error::Interrupted);
            }
            let spill = Arc::new(spill(limits));
            let (sink, held_bytes) = found(self, level, cache, limits, &spill)?;
            report.accounted_bytes = report.accounted_bytes.max(held_bytes + spill.resident_bytes());
            report.root_blocks += self.levels[level].root_block_count();
            report.reused_root_blocks = report.root_blocks;
            let result_bytes = sink.result_bytes();
            write_level(&mut writer, sink.into_pages(), grids[level].size, self.encoding, watch.cancel)?;
            report.spilled_bytes += spill.spilled_bytes();
            let texels_per_unit = 1 << (2 * self.levels[level].root_level);
            (watch.progress)(Progress { done: report.root_blocks, total, texels_per_unit, result_bytes });
        }
        let bytes = writer.finish().map_err(Error::Output)?;
        report.seconds = start.elapsed().as_secs_f64();
        Ok(BakeSummary { grid: grids[0], settings: self.settings, levels: grids.len() as u32, bytes, report })
    }

    /// Links the entries of the parts to a file that replaces the one at `path` when it is placed. See
    /// [`BakePlan::link`]. What exceeds the memory limit goes to the folder of `path`, unless `limits` name
    /// another one.
    ///
    /// # Errors
    /// Returns the errors of [`BakePlan::link`], and [`Error::Io`] if the file cannot be written.
    #[doc(hidden)]
    pub fn stage_link(
        &self,
        cache: &Arc<dyn BakeCache>,
        limits: &BakeOptions,
        watch: Watch<'_>,
        path: &Path,
    ) -> Result<(StagedFile, BakeSummary)> {
        let limits = limits.spilling_beside(path);
        stage(path, |out| self.link(cache, &limits, watch, out))
    }
}

/// Links the entries of a plan's parts to a file in memory. See [`BakePlan::link`].
pub(crate) fn link_in_memory(
    plan: &BakePlan,
    cache: &Arc<dyn BakeCache>,
    limits: &BakeOptions,
) -> Result<ShadowFile> {
    let tree = |level| -> Result<(LightGrid, DepthTree)> {
        let (sink, _) = found(plan, level, cache, limits, &Arc::new(spill(limits)))?;
        Ok((stored_grid(plan.levels[level].grid, plan.settings.region, level), sink.into_pages().tree()?))
    };
    let coarser = (1..plan.levels.len()).map(tree).collect::<Result<Vec<_>>>()?;
    let (grid, finest) = tree(0)?;
    Ok(ShadowFile::new(grid, plan.settings, finest).with_coarser(coarser))
}

/// Returns the pages of a level, and the bytes that they and linking need apart from what can be on disk.
fn found(
    plan: &BakePlan,
    level: usize,
    cache: &Arc<dyn BakeCache>,
    limits: &BakeOptions,
    spill: &Arc<Spill>,
) -> Result<(DepthsSink, u64)> {
    let Placement { grid, root_level, .. } = plan.levels[level];
    // Pages have the other half.
    let part_cache = part_cache(plan, level, cache).within(limits.max_memory_bytes.map(|bytes| bytes / 2));
    let sink = DepthsSink::new(grid.size, root_level, true, spill).with_cache(part_cache);
    sink.check_room()?;
    let is_missing =
        |part: &PlannedPart| part.level as usize == level && !sink.has_part(part.number as usize);
    let mut missing = plan.parts.iter().enumerate().filter(|(_, part)| is_missing(part));
    if let Some((first, _)) = missing.next() {
        let missing = 1 + missing.count();
        // Where nothing else is missing, baking again would not help.
        let (left_out, room_bytes) = sink.left_out();
        if let Some(limit_bytes) = limits.max_memory_bytes.filter(|_| left_out == missing) {
            return Err(Error::MemoryLimit {
                what: "reading a part",
                needed_bytes: 2 * room_bytes,
                limit_bytes,
            });
        }
        return Err(Error::MissingParts { missing, level, first });
    }
    let held_bytes = sink.memory_bytes() + sink.finish_bytes();
    if let Some(limit_bytes) = limits.max_memory_bytes {
        if held_bytes > limit_bytes {
            let what = DepthsSink::FINISHING;
            return Err(Error::MemoryLimit { what, needed_bytes: held_bytes, limit_bytes });
        }
        spill.limit_to(limit_bytes - held_bytes);
        sink.make_room();
    }
    Ok((sink, held_bytes))
}

fn spill(limits: &BakeOptions) -> Spill {
    limits.max_memory_bytes.map_or_else(Spill::unlimited, |bytes| {
        // What linking needs is known when all pages are.
        Spill::new(bytes / 2, limits.spill_folder.clone().unwrap_or_else(std::env::temp_dir))
    })
}

/// Returns the entries of a level.
fn part_cache(plan: &BakePlan, level: usize, cache: &Arc<dyn BakeCache>) -> PartCache {
    let own = plan.parts.iter().filter(|part| part.level as usize == level);
    let keys = own.map(|part| (part.number as usize, part.key));
    PartCache::new(cache, plan.levels[level].parts(), keys)
}
