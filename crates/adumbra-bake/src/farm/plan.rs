//! What is to be baked.

use std::cmp::Reverse;
use std::sync::Arc;

use adumbra::file::LEVEL_STEP;
use adumbra::{Encoding, FileSettings, LightGrid, Region};
use adumbra_scene::Scene;

use crate::cache::CacheKey;
use crate::choose::Choice;
use crate::error::{Error, Result};
use crate::inputs::SceneHashes;
use crate::options::{BakeOptions, ColumnBuilder, FrameChoice, Size};
use crate::plan::{Placement, Plan};
use crate::progress::NEVER;
use crate::triangles::casters::{Bins, SceneClusters};

/// A bake that is planned: its grids, and its parts. Two plans of a scene with the same options are equal.
#[derive(Clone, Debug, PartialEq)]
pub struct BakePlan {
    /// Hash of the scene.
    pub(super) scene: CacheKey,
    /// The settings of the file.
    pub(super) settings: FileSettings,
    pub(super) encoding: Encoding,
    /// The finest first.
    pub(super) levels: Vec<Placement>,
    /// The most costly first.
    pub(super) parts: Vec<PlannedPart>,
}

/// What planning has found of a scene that baking its parts needs.
#[derive(Clone)]
pub(crate) struct Prepared {
    pub(super) clusters: Arc<SceneClusters>,
    pub(super) hashes: Arc<SceneHashes>,
    /// Of each level, the finest first.
    pub(super) bins: Vec<Arc<Bins>>,
}

/// A part of a plan. Its id is its place among [`BakePlan::parts`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlannedPart {
    /// Level of detail, 0 = the finest.
    pub(super) level: u32,
    /// Number among the parts of the level, x fastest.
    pub(super) number: u32,
    /// Number of triangles in reach, with those of every instance counted, and a share for the part itself.
    pub(super) cost: u64,
    pub(super) key: CacheKey,
}

/// Cost of a root block without triangles.
const ROOT_COST: u64 = 64;

impl PlannedPart {
    /// Returns the level of detail that the part belongs to; 0 is the finest.
    pub fn level(&self) -> u32 {
        self.level
    }

    /// Returns an estimate of the work, in units that only other parts of the plan share.
    pub fn cost(&self) -> u64 {
        self.cost
    }

    /// Returns the key of the part's entry.
    pub fn key(&self) -> &CacheKey {
        &self.key
    }
}

impl BakePlan {
    /// Plans the bake of `scene`. Cost: that of finding the triangles in reach of each root block, and,
    /// unless the options have a frame, a forecast.
    ///
    /// # Errors
    /// Returns an error if an option is out of range, or if the scene does not fit `max_memory_bytes`.
    pub fn new(scene: &Scene, options: &BakeOptions) -> Result<Self> {
        Ok(Self::prepared(scene, options)?.0)
    }

    /// Plans the bake of `scene`, and returns what baking its parts needs too.
    pub(crate) fn prepared(scene: &Scene, options: &BakeOptions) -> Result<(Self, Prepared)> {
        let options = BakeOptions { builder: ColumnBuilder::Fast, ..options.clone() };
        let choice = Choice::new(scene, &options, &NEVER)?;
        let hashes = SceneHashes::new(scene);
        let mut parts = Vec::new();
        let mut settings = FileSettings::default();
        let mut bins = Vec::with_capacity(choice.levels.len());
        // The finest last: the file has its settings.
        for level in (0..choice.levels.len()).rev() {
            let plan = choice.plan(scene, level)?;
            settings = plan.settings;
            bins.insert(0, Arc::clone(&plan.root_blocks.casters.bins));
            let own = choice.levels[level].parts();
            let numbers: Vec<usize> = (0..own.count()).collect();
            let keys = hashes.keys(&plan, options.builder, &numbers, |part| own.root_blocks(part));
            parts.extend(numbers.into_iter().zip(keys).map(|(number, key)| PlannedPart {
                level: level as u32,
                number: number as u32,
                cost: own.root_blocks(number).map(|root_block| cost_of(&plan, root_block)).sum(),
                key,
            }));
        }
        parts.sort_by_key(|part| (Reverse(part.cost), part.level, part.number));
        let scene = CacheKey::new(*hashes.all().as_bytes());
        let prepared = Prepared { clusters: choice.clusters, hashes: Arc::new(hashes), bins };
        let plan = Self { scene, settings, encoding: options.encoding, levels: choice.levels, parts };
        Ok((plan, prepared))
    }

    /// Returns the parts, the most costly first.
    pub fn parts(&self) -> &[PlannedPart] {
        &self.parts
    }

    /// Returns the ids of one of `shards` shares of the parts with about the same cost each.
    pub fn shard(&self, shard: usize, shards: usize) -> Vec<usize> {
        (shard..self.parts.len()).step_by(shards.max(1)).collect()
    }

    /// Returns the placement of each level's voxels in the world, the finest first.
    pub fn grids(&self) -> Vec<LightGrid> {
        self.levels.iter().map(|level| level.grid).collect()
    }

    /// Returns the settings of the file.
    pub fn settings(&self) -> &FileSettings {
        &self.settings
    }

    /// Returns options with which a bake on one machine makes the same file.
    pub fn options(&self) -> BakeOptions {
        let grid = self.levels[0].grid;
        let settings = &self.settings;
        BakeOptions {
            frame: match grid.frame {
                adumbra::Frame::Light => FrameChoice::Light,
                adumbra::Frame::Oblique { yaw_radians } => FrameChoice::ObliqueAt(yaw_radians),
            },
            thickness_world: settings.thickness_world,
            assume_ground: settings.assume_ground.into(),
            closed_regions: settings.closed_regions,
            ignore_alpha: settings.ignore_alpha,
            receivers: settings.receivers,
            bounds: settings.bounds,
            bias: settings.bias,
            switch_within_voxels: settings.switch_within_voxels,
            levels: self.levels.len() as u32,
            encoding: self.encoding,
            region: settings.region,
            ..BakeOptions::new(grid.sun, Size::VoxelSize(grid.voxel_size))
        }
    }

    /// Returns the plan of a file with all levels but the finest. `None` if there is only one.
    pub(crate) fn without_finest(&self) -> Option<Self> {
        let levels = self.levels.get(1..).filter(|levels| !levels.is_empty())?.to_vec();
        // The region has the same columns. Count them in texels of the next level.
        let region = self.settings.region;
        let region = region.map(|region| Region { texels: region.texels / LEVEL_STEP, ..region });
        let settings = FileSettings { resolution: levels[0].resolution, region, ..self.settings };
        let coarser = self.parts.iter().filter(|part| part.level > 0);
        let parts = coarser.map(|part| PlannedPart { level: part.level - 1, ..*part }).collect();
        Some(Self { settings, levels, parts, ..self.clone() })
    }

    /// Returns the first texel of a part along x and y of its level's grid, and then its number of texels
    /// along both. The part must be one of this plan's.
    pub fn texels_of(&self, part: &PlannedPart) -> [[u32; 2]; 2] {
        self.levels[part.level as usize].parts().texels(part.number as usize)
    }

    /// Returns the distance from a part to the column of a point in the world, in texels of the finest level.
    pub(crate) fn texels_from(&self, id: usize, p_world: [f64; 3]) -> u64 {
        let part = &self.parts[id];
        let [corner, size] = self.texels_of(part);
        let p_grid = self.levels[part.level as usize].grid.to_grid(p_world);
        let beside = |a: usize| {
            let first = f64::from(corner[a]);
            (first - p_grid[a]).max(p_grid[a] - first - f64::from(size[a])).max(0.0)
        };
        let texels = beside(0).hypot(beside(1));
        // Beyond any grid all parts are equally far.
        texels as u64 * u64::from(LEVEL_STEP.pow(part.level))
    }

    /// Returns the part with an id.
    ///
    /// # Errors
    /// Returns [`Error::NoPart`] if there is none.
    pub(super) fn part(&self, id: usize) -> Result<&PlannedPart> {
        let last = self.parts.len() - 1;
        self.parts.get(id).ok_or(Error::NoPart { id, last })
    }
}

fn cost_of(plan: &Plan<'_>, root_block: usize) -> u64 {
    let casters = &plan.root_blocks.casters;
    let triangles = |&placed| casters.triangles(placed).len() as u64;
    ROOT_COST + casters.in_bin(root_block).iter().map(triangles).sum::<u64>()
}
