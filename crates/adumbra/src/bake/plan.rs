//! What is settled before the first block: grid, rules, casters, and the root blocks of the light's plane.

use std::sync::Arc;

use super::capture::TileRect;
use super::casters::{CasterOptions, Casters};
use super::columns::ColumnRules;
use super::early::Early;
use super::options::{Builder, Options};
use super::{capture, project};
use crate::dag::store::NodeState;
use crate::error::{Error, Result};
use crate::light::{LightExtent, LightGrid};
use crate::paged::Spill;
use crate::scene::Scene;
use crate::settings::Settings;

pub(super) struct Plan<'s> {
    pub(super) grid: LightGrid,
    pub(super) settings: Settings,
    pub(super) rules: ColumnRules,
    pub(super) casters: Casters<'s>,
    /// A root block is 2^root_level texels a side, a root cube as deep.
    pub(super) root_level: u32,
    /// Root cubes along x, y, z.
    pub(super) top_dims: [u32; 3],
    pub(super) workers: usize,
    /// Bytes of the scene, the casters and the top grid.
    pub(super) scene_bytes: u64,
    /// Bytes that each worker holds.
    pub(super) worker_bytes: u64,
    limit_bytes: Option<u64>,
    /// Where what is built goes, if there is a limit.
    pub(super) spill: Option<Arc<Spill>>,
}

/// Smallest level of the root cubes.
const MIN_ROOT_LEVEL: u32 = 5;
/// Largest where a root block's columns are held at once.
const MAX_PLAIN_ROOT_LEVEL: u32 = 10;
/// Root cubes that the top grid aims at across the longer side, as a level.
const TOP_GRID_LEVEL: u32 = 5;

impl<'s> Plan<'s> {
    pub(super) fn new(scene: &'s Scene, options: &Options) -> Result<Self> {
        options.check()?;
        let mut extent = LightExtent::empty(&options.sun);
        match &options.bounds {
            Some(bounds) => extent.add_box(bounds),
            None => add_casters(&mut extent, scene),
        }
        let (resolution, voxel_size) = options.size.resolve(extent.longest_side())?;
        let grid = LightGrid::covering(options.sun, &extent, voxel_size);
        if f64::from(grid.size[2]) > project::DEPTH_MAX_VOXELS {
            return Err(Error::OptionRange {
                option: "--resolution",
                value: format!("{resolution} ({} voxels along the light)", grid.size[2]),
                range: "coarse enough for at most 2097152 voxels along the light; lower it",
            });
        }
        let aim = resolution.ilog2().saturating_sub(TOP_GRID_LEVEL).max(MIN_ROOT_LEVEL);
        let root_level = match options.builder {
            Builder::Fast => aim,
            Builder::Plain => aim.min(MAX_PLAIN_ROOT_LEVEL),
        };
        let top_dims = grid.size.map(|s| s.div_ceil(1 << root_level));
        let rules = ColumnRules {
            bias: options.bias,
            thickness_voxels: options.thickness_world / voxel_size,
            assume_ground: options.assume_ground,
            receivers: options.receivers,
            depth_voxels: grid.size[2],
        };
        let caster_options = CasterOptions {
            closed_regions: options.closed_regions,
            ignore_alpha: options.ignore_alpha,
            outlines: options.builder == Builder::Fast,
        };
        let reach = rules.reach_texels() + 1.0;
        let casters =
            Casters::new(scene, caster_options, &grid, 1 << root_level, [top_dims[0], top_dims[1]], reach);
        let settings = Settings {
            resolution,
            thickness_world: options.thickness_world,
            assume_ground: options.assume_ground,
            closed_regions: options.closed_regions,
            ignore_alpha: options.ignore_alpha,
            receivers: options.receivers,
            switch_within_voxels: options.switch_within_voxels,
            bounds: options.bounds,
            bias: options.bias,
            triangles: casters.instanced_triangles(),
            instances: scene.instances.iter().filter(|i| i.casts).count() as u64,
        };
        // A root's state while baking, and its word of the finished graph.
        let roots: u64 = top_dims.iter().map(|&n| u64::from(n)).product();
        let top_bytes = roots * (size_of::<NodeState>() as u64 + 4);
        let scene_bytes = scene.memory_bytes() + casters.memory_bytes() + top_bytes;
        let worker_bytes = match options.builder {
            Builder::Fast => super::descent::working_bytes(&casters, top_dims),
            Builder::Plain => capture::working_bytes(1 << (2 * root_level)),
        };
        let mut plan = Self {
            grid,
            settings,
            rules,
            casters,
            root_level,
            top_dims,
            workers: rayon::current_num_threads(),
            scene_bytes,
            worker_bytes,
            limit_bytes: options.max_memory_bytes,
            spill: None,
        };
        if let Some(limit) = plan.limit_bytes {
            // Fewer workers rather than none; half of what is left is for what is built.
            let room = limit.saturating_sub(scene_bytes) / 2;
            plan.workers = plan.workers.min((room / worker_bytes.max(1)) as usize).max(1);
        }
        plan.check_memory("the scene and one block", scene_bytes + worker_bytes)?;
        if let Some(limit) = plan.limit_bytes {
            let room = limit.saturating_sub(plan.baking_bytes());
            let folder = options.spill_folder.clone().unwrap_or_else(std::env::temp_dir);
            plan.spill = Some(Arc::new(Spill::new(room, folder)));
        }
        Ok(plan)
    }

    /// What is left of the columns' freedom.
    pub(super) fn early(&self) -> Early {
        Early { within_voxels: self.settings.switch_within_voxels, depth_voxels: self.grid.size[2] }
    }

    /// Bytes of all but what is built.
    pub(super) fn baking_bytes(&self) -> u64 {
        self.scene_bytes + self.workers as u64 * self.worker_bytes
    }

    /// Bytes of pages in memory.
    ///
    /// # Errors
    /// [`Error::Io`] where the disk failed.
    pub(super) fn paged_bytes(&self) -> Result<u64> {
        let Some(spill) = &self.spill else { return Ok(0) };
        spill.check()?;
        Ok(spill.resident_bytes())
    }

    /// Pages make room for `held_bytes` beside the scene.
    pub(super) fn make_room(&self, held_bytes: u64) {
        if let (Some(spill), Some(limit)) = (&self.spill, self.limit_bytes) {
            spill.shrink_to(limit.saturating_sub(self.scene_bytes + held_bytes));
        }
    }

    pub(super) fn check_memory(&self, what: &'static str, needed_bytes: u64) -> Result<()> {
        match self.limit_bytes {
            Some(limit_bytes) if needed_bytes > limit_bytes => {
                Err(Error::MemoryLimit { what, needed_bytes, limit_bytes })
            }
            _ => Ok(()),
        }
    }

    /// Root blocks, x fastest.
    pub(super) fn tiles(&self) -> usize {
        (self.top_dims[0] * self.top_dims[1]) as usize
    }

    pub(super) fn tile_rect(&self, tile: usize) -> TileRect {
        let side = 1 << self.root_level;
        let (tx, ty) = (tile as u32 % self.top_dims[0], tile as u32 / self.top_dims[0]);
        let (x, y) = (tx * side, ty * side);
        TileRect { x, y, width: side.min(self.grid.size[0] - x), height: side.min(self.grid.size[1] - y) }
    }
}

fn add_casters(extent: &mut LightExtent, scene: &Scene) {
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        for &v in mesh.triangles.iter().flatten() {
            extent.add(instance.to_world(mesh.positions[v as usize]));
        }
    }
}
