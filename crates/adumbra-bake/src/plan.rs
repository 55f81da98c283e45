//! The plan of a bake, made before the first block: root blocks, settings and the memory budget.

use std::sync::{Arc, Mutex};

use crate::cache::PartGrid;
use crate::columns::capture;
use crate::columns::limit::SwitchLimit;
use crate::columns::rules::{ColumnRules, NormalOffset};
use crate::error::{BakeField, Error, Result};
use crate::options::{AssumeGround, BakeOptions, ColumnBuilder};
use crate::pages::Spill;
use crate::root_blocks::RootBlocks;
use crate::sink::depths::top_bytes;
use crate::triangles::casters::{Bins, CasterOptions, Casters, SceneClusters};
use crate::triangles::corners::Corners;
use crate::triangles::depth::DEPTH_MAX_VOXELS;
use adumbra::FileSettings;
use adumbra::file::LEVEL_STEP;
use adumbra::grid::{Frame, LightExtent, LightGrid};
use adumbra::layout::depths::page::PAGE_LEVEL;
use adumbra::query::MAX_FIXED_SIDE;
use adumbra::{Bounds, RangeError, Sun};
use adumbra_scene::{Instance, Scene, UpAxis};
use rayon::prelude::*;

pub(crate) struct Plan<'s> {
    pub(crate) root_blocks: RootBlocks<'s>,
    pub(crate) settings: FileSettings,
    pub(crate) workers: usize,
    /// Bytes of the scene, the casters and the top grid.
    pub(crate) scene_bytes: u64,
    /// Bytes that each worker holds.
    pub(crate) worker_bytes: u64,
    limit_bytes: Option<u64>,
    /// Storage for finished pages.
    pub(crate) spill: Arc<Spill>,
}

/// Where the grid of one level is, and how it is cut into root blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    pub(crate) grid: LightGrid,
    /// Texels on the longest side of the scene, at this level.
    pub(crate) resolution: u32,
    /// A root block is 2^root_level texels a side.
    pub(crate) root_level: u32,
}

impl Placement {
    /// Places the grid of a level, 0 = the finest, in `frame`.
    ///
    /// # Errors
    /// Returns [`Error::Range`] if the grid has too many voxels along an axis.
    pub(crate) fn new(
        extents: &Extents<'_>,
        options: &BakeOptions,
        frame: Frame,
        level: u32,
    ) -> Result<Self> {
        let extent = extents.in_frame(frame);
        let (finest, voxel_size) = extents.resolution_and_voxel_size(options)?;
        let step = LEVEL_STEP.pow(level);
        let (resolution, voxel_size) = (finest.div_ceil(step), voxel_size * f64::from(step));
        let grid = LightGrid::covering(options.sun, &extent, voxel_size).snapped_to(lattice_step(finest));
        Self::on(grid, resolution, options)
    }

    /// Places a level on a grid.
    ///
    /// # Errors
    /// Returns [`Error::Range`] if the grid has too many voxels along an axis.
    pub(crate) fn on(grid: LightGrid, resolution: u32, options: &BakeOptions) -> Result<Self> {
        if f64::from(grid.size[2]) > DEPTH_MAX_VOXELS {
            return Err(RangeError::new(
                BakeField::Resolution,
                format!("{resolution} ({} voxels along the light)", grid.size[2]),
                "coarse enough for at most 2097152 voxels along the light; lower it",
            )
            .into());
        }
        let across = grid.size[0].max(grid.size[1]);
        if across > MAX_FIXED_SIDE {
            return Err(RangeError::new(
                BakeField::Resolution,
                format!("{resolution} ({across} texels across, in the {} frame)", grid.frame.name()),
                "coarse enough for at most 516096 texels across; lower it, or use the light's frame",
            )
            .into());
        }
        // Under a low sun an oblique grid is far longer than the resolution.
        let side = resolution.max(across / LONG_GRID);
        let aim = side.ilog2().saturating_sub(TOP_GRID_LEVEL).max(MIN_ROOT_LEVEL);
        let root_level = match options.builder {
            ColumnBuilder::Fast => aim,
            ColumnBuilder::Plain => aim.min(MAX_PLAIN_ROOT_LEVEL),
        };
        Ok(Self { grid, resolution, root_level })
    }

    /// Returns the number of root blocks along x, y, z.
    pub(crate) fn blocks(&self) -> [u32; 3] {
        self.grid.size.map(|s| s.div_ceil(1 << self.root_level))
    }

    /// Returns the number of root blocks in the light's plane.
    pub(crate) fn root_block_count(&self) -> usize {
        self.blocks()[..2].iter().map(|&n| n as usize).product()
    }

    /// Returns how the grid is cut into parts.
    pub(crate) fn parts(&self) -> PartGrid {
        PartGrid::new(self.grid.size, self.root_level)
    }
}

/// Smallest level of the root blocks.
const MIN_ROOT_LEVEL: u32 = 5;
/// Largest root level for the plain builder, which holds all columns of a root block at once.
const MAX_PLAIN_ROOT_LEVEL: u32 = 10;
/// log2 of the number of root blocks that a bake aims at across the resolution.
const TOP_GRID_LEVEL: u32 = 5;
/// A grid that is longer than this many times the resolution has larger root blocks:
/// at most 2 · `LONG_GRID` · 2^[`TOP_GRID_LEVEL`] of them across.
const LONG_GRID: u32 = 4;

/// Grids begin and end at multiples of a lattice step from the world's origin, so that texels stay where they
/// are when a scene grows. The step is this share of the resolution, within the limits below, so that small
/// grids are not mostly margin.
const STEPS_ACROSS: u32 = 8;
const MIN_STEP: u32 = 8;
/// Largest lattice step, texels: a page of the file.
const MAX_STEP: u32 = 1 << PAGE_LEVEL;

/// Upper bound on the relative rounding error of a coordinate.
const ROUNDING: f64 = 1e-9;

/// Returns the lattice step, in texels, of a bake whose finest level has this resolution. All levels use it,
/// so that each has whole steps where the finest one has.
pub(crate) fn lattice_step(finest_resolution: u32) -> u32 {
    (finest_resolution / STEPS_ACROSS).clamp(MIN_STEP, MAX_STEP)
}

/// Returns which triangles are casters.
pub(crate) fn caster_options(options: &BakeOptions) -> CasterOptions {
    CasterOptions {
        closed_regions: options.closed_regions,
        ignore_alpha: options.ignore_alpha,
        outlines: options.builder == ColumnBuilder::Fast,
        limit_bytes: options.max_memory_bytes,
    }
}

impl<'s> Plan<'s> {
    /// Plans a bake of the grid that was placed. `clusters` are those for [`caster_options`], and `bins` are
    /// those of an earlier plan of the same bake, if there was one.
    pub(crate) fn placed(
        scene: &'s Scene,
        options: &BakeOptions,
        placement: Placement,
        clusters: &Arc<SceneClusters>,
        bins: Option<&Arc<Bins>>,
    ) -> Result<Self> {
        let Placement { grid, resolution, root_level } = placement;
        let top_dims = placement.blocks();
        let rules = ColumnRules {
            bias: options.bias,
            thickness: ColumnRules::thickness_of(options.thickness_world / grid.voxel_along_light()),
            level_lift: None,
            receivers: options.receivers,
            depth_voxels: grid.size[2],
            normal_offset: NormalOffset::new(&options.bias, &grid),
        };
        // An undecided `Auto` counts as no ground.
        let assume_ground = options.assume_ground == AssumeGround::Yes;
        let rules = rules.with_ground(assume_ground, &grid);
        let reach = rules.contact_reach_texels() + 1.0;
        let root_blocks = [top_dims[0], top_dims[1]];
        let clusters = Arc::clone(clusters);
        let casters = match bins {
            Some(bins) => Casters { scene, clusters, bins: Arc::clone(bins) },
            None => Casters::new(scene, clusters, &grid, 1 << root_level, root_blocks, reach),
        };
        let settings = FileSettings {
            resolution,
            thickness_world: options.thickness_world,
            assume_ground,
            closed_regions: options.closed_regions,
            ignore_alpha: options.ignore_alpha,
            scene_is_z_up: scene.up == UpAxis::Z,
            receivers: options.receivers,
            switch_within_voxels: options.switch_within_voxels,
            dark_after_voxels: 0,
            bounds: options.bounds,
            region: options.region,
            bias: options.bias,
            triangles: casters.instanced_triangles(),
            instances: scene.instances.iter().filter(|i| i.casts).count() as u64,
        };
        let top_bytes = top_bytes(u64::from(top_dims[0]) * u64::from(top_dims[1]), root_level);
        let scene_bytes = scene.memory_bytes() + casters.memory_bytes() + top_bytes;
        let working_bytes = match options.builder {
            ColumnBuilder::Fast => crate::fast::descent::working_bytes(&casters, top_dims),
            ColumnBuilder::Plain => capture::working_bytes(1 << (2 * root_level)),
        };
        let worker_bytes = working_bytes + crate::sink::building_bytes(root_level);
        let limit = SwitchLimit { within_voxels: options.switch_within_voxels, depth_voxels: grid.size[2] };
        let mut plan = Self {
            root_blocks: RootBlocks { grid, rules, limit, casters, root_level, top_dims },
            settings,
            workers: rayon::current_num_threads(),
            scene_bytes,
            worker_bytes,
            limit_bytes: options.max_memory_bytes,
            spill: Arc::new(Spill::unlimited()),
        };
        if let Some(limit) = plan.limit_bytes {
            // Use at least one worker. Half of the remaining memory is for the structure that is built.
            let room = limit.saturating_sub(scene_bytes) / 2;
            plan.workers = plan.workers.min((room / worker_bytes.max(1)) as usize).max(1);
        }
        plan.check_memory("the scene and one block", scene_bytes + worker_bytes)?;
        if let Some(limit) = plan.limit_bytes {
            let room = limit.saturating_sub(plan.baking_bytes());
            let folder = options.spill_folder.clone().unwrap_or_else(std::env::temp_dir);
            plan.spill = Arc::new(Spill::new(room, folder));
        }
        Ok(plan)
    }

    /// Bytes of everything but the structure that is built.
    pub(crate) fn baking_bytes(&self) -> u64 {
        self.scene_bytes + self.workers as u64 * self.worker_bytes
    }

    /// Bytes for entries while they are read, if memory is limited: the bytes that workers need later.
    pub(crate) fn room_for_entries(&self) -> Option<u64> {
        self.limit_bytes.map(|_| self.workers as u64 * self.worker_bytes)
    }

    /// Returns the bytes of pages in memory.
    ///
    /// # Errors
    /// Returns [`Error::Spill`] if reading or writing the disk failed.
    pub(crate) fn paged_bytes(&self) -> Result<u64> {
        self.spill.check()?;
        Ok(self.spill.resident_bytes())
    }

    /// Limits the memory for pages, while a structure of `held_bytes` is built, to what the bake and the
    /// structure leave. The `finish_bytes` that finishing it will need stay free from the start: if pages
    /// went to disk only then, they would leave holes too small for large allocations.
    pub(crate) fn limit_pages_while_building(&self, held_bytes: u64, finish_bytes: u64) {
        let working_bytes = self.workers as u64 * self.worker_bytes;
        self.limit_pages(self.scene_bytes + held_bytes + working_bytes.max(finish_bytes));
    }

    /// Limits the memory for pages to the limit less `held_bytes`.
    pub(crate) fn limit_pages(&self, held_bytes: u64) {
        if let Some(limit) = self.limit_bytes {
            self.spill.limit_to(limit.saturating_sub(held_bytes));
        }
    }

    pub(crate) fn check_memory(&self, what: &'static str, needed_bytes: u64) -> Result<()> {
        match self.limit_bytes {
            Some(limit_bytes) if needed_bytes > limit_bytes => {
                Err(Error::MemoryLimit { what, needed_bytes, limit_bytes })
            }
            _ => Ok(()),
        }
    }
}

/// The extents of the bounds or the scene that a bake covers, along the axes of frames.
pub(crate) struct Extents<'s> {
    scene: &'s Scene,
    pub(crate) corners: Corners,
    sun: Sun,
    bounds: Option<Bounds>,
    /// Along the axes of [`Frame::Light`].
    light: LightExtent,
    /// Along the axes of the other frame that was last requested.
    other: Mutex<Option<LightExtent>>,
}

impl<'s> Extents<'s> {
    /// Finds the extent in the light's frame.
    pub(crate) fn new(scene: &'s Scene, options: &BakeOptions) -> Self {
        let (sun, bounds) = (options.sun, options.bounds);
        let light = LightExtent::in_frame(&sun, Frame::Light);
        let mut extents =
            Self { scene, corners: Corners::new(scene), sun, bounds, light, other: Mutex::default() };
        extents.light = extents.found(Frame::Light);
        extents
    }

    /// Returns the resolution, and the size of a voxel. The resolution counts texels as the sun sees the
    /// scene, so that voxels have one size in either frame.
    pub(crate) fn resolution_and_voxel_size(&self, options: &BakeOptions) -> Result<(u32, f64)> {
        options.size.resolve(self.longest_side())
    }

    /// Returns the longest side as the sun sees the scene, in world units.
    pub(crate) fn longest_side(&self) -> f64 {
        self.light.longest_side()
    }

    /// Returns the extent along the axes of a frame.
    fn in_frame(&self, frame: Frame) -> LightExtent {
        if frame == Frame::Light {
            return self.light;
        }
        let mut other = self.other.lock().unwrap_or_else(|e| e.into_inner());
        match *other {
            Some(known) if known.frame == frame => known,
            _ => *other.insert(self.found(frame)),
        }
    }

    fn found(&self, frame: Frame) -> LightExtent {
        let mut extent = LightExtent::in_frame(&self.sun, frame);
        if let Some(bounds) = &self.bounds {
            extent.add_box(bounds);
            return extent;
        }
        let of_instance = |mut extent: LightExtent, instance: &Instance| {
            // Most instances are far from all sides.
            let mut around = LightExtent { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3], ..extent };
            self.corners.box_of(instance).into_iter().for_each(|corner| around.add(corner));
            let is_inside = (0..3).all(|a| {
                let slack = ROUNDING * (around.min[a].abs() + around.max[a].abs());
                extent.min[a] + slack < around.min[a] && around.max[a] + slack < extent.max[a]
            });
            if is_inside {
                return extent;
            }
            for corner in self.corners.of(instance) {
                extent.add(instance.to_world(corner.position));
            }
            extent
        };
        let extents = self.scene.instances.par_iter().fold(|| extent, of_instance);
        extents.reduce(|| extent, |one, other| one.joined(&other))
    }
}
