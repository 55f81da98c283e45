//! Bakes parts of a plan.

use std::collections::HashSet;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use adumbra::layout::depths::page::PAGE_LEVEL;
use adumbra_scene::Scene;

use super::plan::{BakePlan, Prepared};
use crate::bake::run::Run;
use crate::cache::{BakeCache, CacheKey, PartCache};
use crate::error::{Error, Result};
use crate::inputs::SceneHashes;
use crate::options::{BakeOptions, ColumnBuilder};
use crate::plan::{Plan, caster_options};
use crate::progress::{Progress, Report, Watch};
use crate::sink::Structure;
use crate::sink::depths::{DepthsBlock, DepthsSink};
use crate::sink::recent::{RecentBlocks, RecentOfLevel};
use crate::tally::Tally;
use crate::triangles::casters::{Bins, SceneClusters};

/// Bakes parts of a plan, of any level and in any order.
pub struct PartBaker<'s> {
    scene: &'s Scene,
    plan: &'s BakePlan,
    options: BakeOptions,
    clusters: Arc<SceneClusters>,
    hashes: Arc<SceneHashes>,
    /// The casters of each level, if they are known.
    bins: Vec<Arc<Bins>>,
    /// The root blocks of earlier bakes.
    recent: Option<Arc<RecentBlocks<DepthsBlock>>>,
    /// What is known of each level, once a part of it has been asked for.
    levels: Vec<Mutex<Option<Arc<Plan<'s>>>>>,
}

/// What became of parts that were to be baked.
#[derive(Clone, Copy, Debug, Default)]
pub struct BakedParts {
    /// Number of parts that were baked.
    pub baked: usize,
    /// Number of parts whose entries were there.
    pub reused: usize,
    /// Number of texels that were evaluated one by one.
    pub drawn_texels: u64,
    /// Wall-clock time in seconds.
    pub seconds: f64,
    /// Largest sum of the bytes that the bake accounted for.
    pub accounted_bytes: u64,
}

impl<'s> PartBaker<'s> {
    /// Prepares to bake parts of `plan`, which must be a plan of `scene`. Of `limits`, the memory limit and
    /// the folder for temporary files count; everything else is in the plan.
    ///
    /// # Errors
    /// Returns [`Error::SceneChanged`] if the scene is not the one that was planned.
    pub fn new(scene: &'s Scene, plan: &'s BakePlan, limits: &BakeOptions) -> Result<Self> {
        let hashes = SceneHashes::new(scene);
        if CacheKey::new(*hashes.all().as_bytes()) != plan.scene {
            return Err(Error::SceneChanged("the scene is not the one that was planned"));
        }
        let clusters = SceneClusters::new(scene, caster_options(&plan.options()));
        let prepared = Prepared { clusters, hashes: Arc::new(hashes), bins: Vec::new() };
        Ok(Self::prepared(scene, plan, limits, prepared))
    }

    /// Prepares to bake parts of `plan` with what planning has found of `scene`. See [`PartBaker::new`].
    pub(crate) fn prepared(
        scene: &'s Scene,
        plan: &'s BakePlan,
        limits: &BakeOptions,
        prepared: Prepared,
    ) -> Self {
        let options = BakeOptions {
            max_memory_bytes: limits.max_memory_bytes,
            spill_folder: limits.spill_folder.clone(),
            ..plan.options()
        };
        let Prepared { clusters, hashes, bins } = prepared;
        let levels = plan.levels.iter().map(|_| Mutex::default()).collect();
        Self { scene, plan, options, clusters, hashes, bins, recent: None, levels }
    }

    /// Takes root blocks that are smaller than pages from earlier bakes, and keeps those that are built.
    pub(crate) fn with_recent(mut self, recent: Arc<RecentBlocks<DepthsBlock>>) -> Self {
        self.recent = Some(recent);
        self
    }

    /// Bakes the parts with these ids whose entries are not in `cache` yet, and puts each there as soon as it
    /// is done. What is damaged is made again. Parts of coarser levels come first, and of each level they
    /// come in the order of `ids`.
    ///
    /// # Errors
    /// Returns [`Error::NoPart`] for an id that the plan does not have, [`Error::SceneChanged`] if the parts
    /// of this program have other keys, and the errors of [`Bake::in_memory`](crate::Bake::in_memory). What
    /// was done before is in `cache`.
    pub fn bake(&self, ids: &[usize], cache: &Arc<dyn BakeCache>, watch: Watch<'_>) -> Result<BakedParts> {
        let mut by_level: Vec<Vec<_>> = vec![Vec::new(); self.levels.len()];
        let mut seen = HashSet::new();
        for &id in ids.iter().filter(|&&id| seen.insert(id)) {
            let part = self.plan.part(id)?;
            by_level[part.level as usize].push((part.number as usize, part.key));
        }
        let root_blocks_of = |(level, planned): (usize, &Vec<(usize, CacheKey)>)| -> usize {
            let parts = self.plan.levels[level].parts();
            planned.iter().map(|(number, _)| parts.root_blocks(*number).count()).sum()
        };
        let total = by_level.iter().enumerate().map(root_blocks_of).sum();
        let start = Instant::now();
        let (mut all, mut before) = (BakedParts::default(), 0);
        for (level, planned) in by_level.iter().enumerate().rev().filter(|(_, planned)| !planned.is_empty()) {
            let progress = |p: Progress| {
                (watch.progress)(Progress { done: before + p.done, total, ..p });
            };
            let done = self.bake_of_level(level, planned, cache, Watch::new(&progress, watch.cancel))?;
            before += root_blocks_of((level, planned));
            all.baked += done.baked;
            all.reused += done.reused;
            all.drawn_texels += done.drawn_texels;
            all.accounted_bytes = all.accounted_bytes.max(done.accounted_bytes);
        }
        Ok(BakedParts { seconds: start.elapsed().as_secs_f64(), ..all })
    }

    /// Bakes parts of a level: numbers and planned keys.
    fn bake_of_level(
        &self,
        level: usize,
        planned: &[(usize, CacheKey)],
        cache: &Arc<dyn BakeCache>,
        watch: Watch<'_>,
    ) -> Result<BakedParts> {
        let plan = self.level(level)?;
        let parts = self.plan.levels[level].parts();
        let numbers: Vec<usize> = planned.iter().map(|(number, _)| *number).collect();
        let keys = self.hashes.keys(&plan, ColumnBuilder::Fast, &numbers, |part| parts.root_blocks(part));
        if planned.iter().zip(&keys).any(|((_, planned), key)| planned != key) {
            return Err(Error::SceneChanged("the plan was made by another version of this program"));
        }
        let part_cache =
            PartCache::new(cache, parts.clone(), planned.iter().copied()).within(plan.room_for_entries());
        let mut sink =
            DepthsSink::new(plan.root_blocks.grid.size, plan.root_blocks.root_level, true, &plan.spill)
                .for_entries_alone(part_cache);
        sink.check_room()?;
        let missing: Vec<usize> = numbers.iter().copied().filter(|&part| !sink.has_part(part)).collect();
        let root_blocks: Vec<usize> = missing.iter().flat_map(|&part| parts.root_blocks(part)).collect();
        if let Some(recent) = self.recent.as_ref().filter(|_| plan.root_blocks.root_level < PAGE_LEVEL) {
            let keys = self.hashes.keys(&plan, ColumnBuilder::Fast, &root_blocks, std::iter::once);
            let keys = root_blocks.iter().copied().zip(keys).collect();
            sink = sink.with_recent(RecentOfLevel { all: Arc::clone(recent), level, keys });
        }
        let reused_root_blocks =
            numbers.iter().map(|&part| parts.root_blocks(part).count()).sum::<usize>() - root_blocks.len();
        let progress = |p: Progress| {
            (watch.progress)(Progress { done: reused_root_blocks + p.done, ..p });
        };
        let tally = Tally::new(&plan, root_blocks.len(), Instant::now(), &progress);
        let run =
            Run { plan: &plan, root_blocks: &root_blocks, cancel: watch.cancel, keeps_room_to_finish: false };
        run.each_block(self.options.builder, &sink, &tally)?;
        sink.check_room()?;
        let Report { drawn_texels, accounted_bytes, .. } = tally.report();
        Ok(BakedParts {
            baked: missing.len(),
            reused: numbers.len() - missing.len(),
            drawn_texels,
            seconds: 0.0,
            accounted_bytes,
        })
    }

    fn level(&self, level: usize) -> Result<Arc<Plan<'s>>> {
        let mut slot = self.levels[level].lock().unwrap_or_else(|e| e.into_inner());
        if let Some(plan) = &*slot {
            return Ok(Arc::clone(plan));
        }
        let (placement, bins) = (self.plan.levels[level], self.bins.get(level));
        let plan = Plan::placed(self.scene, &self.options, placement, &self.clusters, bins)?;
        Ok(Arc::clone(slot.insert(Arc::new(plan))))
    }
}
