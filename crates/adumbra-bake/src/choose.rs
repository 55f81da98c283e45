//! The plan of a bake in the frame that its options ask for.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use adumbra::{FileSettings, Frame};
use adumbra_scene::Scene;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::fast::descent::{DescentBuffers, build_root};
use crate::options::{BakeOptions, FrameChoice, LOWEST_OBLIQUE_DEGREES, Size};
use crate::plan::{Extents, Placement, Plan, caster_options};
use crate::progress::NEVER;
use crate::region_grids::placements;
use crate::sink::depths::DepthsSink;
use crate::sink::{BlockSink, Structure};
use crate::triangles::casters::{CasterOptions, SceneClusters, sorting_bytes};
use crate::yaw::dominant_yaw_radians;

/// A forecast bakes at the resolution divided by this, clamped to these limits.
const COARSER: u32 = 8;
const FORECAST_RESOLUTIONS: [u32; 2] = [512, 2048];
/// A scene with more triangle corners than this is forecast from a sample of its blocks with about this many
/// corners.
const FORECAST_CORNERS: u64 = 1_000_000;

/// The choices that all levels of a bake share.
pub(crate) struct Choice {
    /// The options, with a decision on the ground.
    options: BakeOptions,
    pub(crate) clusters: Arc<SceneClusters>,
    /// The grid of each level, the finest first.
    pub(crate) levels: Vec<Placement>,
}

impl Choice {
    /// Decides on the ground, chooses the frame, and places the grids of all levels.
    pub(crate) fn new(scene: &Scene, options: &BakeOptions, cancel: &AtomicBool) -> Result<Self> {
        options.check()?;
        let options = BakeOptions { assume_ground: options.assume_ground.decided(scene), ..options.clone() };
        let options = &options;
        check_sorting(scene, options)?;
        let clusters = SceneClusters::new(scene, caster_options(options));
        let levels = match options.region {
            Some(region) => placements(scene, &clusters, options, region)?,
            None => chosen(scene, &clusters, options, cancel)?,
        };
        Ok(Self { options: options.clone(), clusters, levels })
    }

    /// Plans the bake of a level.
    pub(crate) fn plan<'s>(&self, scene: &'s Scene, level: usize) -> Result<Plan<'s>> {
        Plan::placed(scene, &self.options, self.levels[level], &self.clusters, None)
    }

    /// Plans the bake of the coarsest level.
    pub(crate) fn coarsest<'s>(&self, scene: &'s Scene) -> Result<Plan<'s>> {
        self.plan(scene, self.levels.len() - 1)
    }

    /// Returns the settings of the file. From level to level only the resolution differs, so those of any
    /// plan will do.
    pub(crate) fn settings(&self, of_any_level: &Plan<'_>) -> FileSettings {
        FileSettings { resolution: self.levels[0].resolution, ..of_any_level.settings }
    }
}

/// Places the grids of all levels around the scene, in the frame that is chosen.
fn chosen(
    scene: &Scene,
    clusters: &Arc<SceneClusters>,
    options: &BakeOptions,
    cancel: &AtomicBool,
) -> Result<Vec<Placement>> {
    let extents = Extents::new(scene, options);
    let frame = frame(scene, clusters, options, &extents, cancel)?;
    let (frame, finest) = match Placement::new(&extents, options, frame, 0) {
        // Under a low sun the upright grid may be too wide.
        Err(Error::Range(_)) if options.frame == FrameChoice::Auto => {
            (Frame::Light, Placement::new(&extents, options, Frame::Light, 0)?)
        }
        placement => (frame, placement?),
    };
    let coarser = 1..options.level_count(finest.resolution);
    let coarser = coarser.map(|level| Placement::new(&extents, options, frame, level));
    std::iter::once(Ok(finest)).chain(coarser).collect()
}

/// Returns the frame that the options ask for.
pub(crate) fn frame(
    scene: &Scene,
    clusters: &Arc<SceneClusters>,
    options: &BakeOptions,
    extents: &Extents<'_>,
    cancel: &AtomicBool,
) -> Result<Frame> {
    match options.frame {
        FrameChoice::Light => Ok(Frame::Light),
        FrameChoice::Oblique => Ok(upright(scene)),
        FrameChoice::ObliqueAt(yaw_radians) => Ok(Frame::Oblique { yaw_radians }),
        FrameChoice::Auto => smaller(scene, options, clusters, extents, cancel),
    }
}

/// Plans the bake of the finest level of `scene`.
pub(crate) fn plan<'s>(scene: &'s Scene, options: &BakeOptions) -> Result<Plan<'s>> {
    Choice::new(scene, options, &NEVER)?.plan(scene, 0)
}

/// Checks that sorting the scene's triangles fits the memory limit.
pub(crate) fn check_sorting(scene: &Scene, options: &BakeOptions) -> Result<()> {
    let needed_bytes = scene.memory_bytes() + sorting_bytes(scene, caster_options(options));
    match options.max_memory_bytes {
        Some(limit_bytes) if needed_bytes > limit_bytes => {
            Err(Error::MemoryLimit { what: "sorting the scene's triangles", needed_bytes, limit_bytes })
        }
        _ => Ok(()),
    }
}

fn upright(scene: &Scene) -> Frame {
    Frame::Oblique { yaw_radians: dominant_yaw_radians(scene) }
}

/// Returns the frame in which the file will probably be smaller.
fn smaller(
    scene: &Scene,
    options: &BakeOptions,
    clusters: &Arc<SceneClusters>,
    extents: &Extents<'_>,
    cancel: &AtomicBool,
) -> Result<Frame> {
    if options.sun.elevation_degrees() < LOWEST_OBLIQUE_DEGREES {
        return Ok(Frame::Light);
    }
    // Only the fast builder is cheap enough; the columns are the same.
    let with_outlines = CasterOptions { outlines: true, ..caster_options(options) };
    let clusters = if caster_options(options).outlines {
        Arc::clone(clusters)
    } else {
        SceneClusters::new(scene, with_outlines)
    };
    let (resolution, voxel_size) = extents.resolution_and_voxel_size(options)?;
    let [least, most] = FORECAST_RESOLUTIONS;
    let coarse = (resolution / COARSER).clamp(least, most).min(resolution);
    let coarse = BakeOptions {
        size: Size::VoxelSize(voxel_size * f64::from(resolution) / f64::from(coarse)),
        ..options.clone()
    };
    let oblique = upright(scene);
    // Under a low sun the upright grid may be too wide.
    let forecast = |frame| forecast_bytes(scene, &coarse, frame, &clusters, extents, cancel);
    let oblique_bytes = match forecast(oblique) {
        Err(Error::Range(_)) => return Ok(Frame::Light),
        bytes => bytes?,
    };
    let light_bytes = forecast(Frame::Light)?;
    Ok(if oblique_bytes <= light_bytes { oblique } else { Frame::Light })
}

/// Builds a sample of the blocks and returns the bytes that all blocks would take as depths. The order of
/// triangles does not affect which blocks are sampled. The memory limit applies as in a bake.
fn forecast_bytes(
    scene: &Scene,
    options: &BakeOptions,
    frame: Frame,
    clusters: &Arc<SceneClusters>,
    extents: &Extents<'_>,
    cancel: &AtomicBool,
) -> Result<f64> {
    let placement = Placement::new(extents, options, frame, 0)?;
    let plan = Plan::placed(scene, options, placement, clusters, None)?;
    let blocks = plan.root_blocks.count();
    let corners = plan.root_blocks.corners_over(&extents.corners);
    let all = corners.iter().sum::<u64>().max(1);
    let samples = (blocks as u64 * FORECAST_CORNERS / all).clamp(1, blocks as u64) as usize;
    // The blocks side by side, as if they were a row of the grid.
    let level = plan.root_blocks.root_level;
    let row = [(samples as u32) << level, 1 << level, plan.root_blocks.grid.size[2]];
    let depths = DepthsSink::new(row, level, true, &plan.spill);
    let sampled: Vec<usize> = plan.root_blocks.sampled(samples, |block| corners[block]).collect();
    let held_bytes = || Ok::<_, Error>(plan.baking_bytes() + depths.memory_bytes() + plan.paged_bytes()?);
    let next = AtomicUsize::new(0);
    let work = || -> Result<()> {
        let mut buffers = DescentBuffers::default();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(&block) = sampled.get(number) else { break };
            let built = build_root(&plan.root_blocks, block, &depths, &mut buffers, cancel)?;
            depths.taken(number, built);
            plan.check_memory("the forecast of the frame", held_bytes()?)?;
        }
        Ok(())
    };
    // No more workers than the limit has room for.
    (0..plan.workers).into_par_iter().with_max_len(1).try_for_each(|_| work())?;
    let bytes = 4 * depths.into_pages().tree()?.code().len();
    Ok(bytes as f64 * blocks as f64 / samples as f64)
}
