//! Cuts a world that is too wide for one file into regions, each with its own file.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::sync::Arc;

use adumbra::{Frame, LightGrid, RangeError, Region};
use adumbra_scene::Scene;

use crate::choose::{check_sorting, frame};
use crate::error::{BakeField, Error, Result};
use crate::options::{BakeOptions, FrameChoice, Size};
use crate::plan::{Extents, caster_options};
use crate::progress::NEVER;
use crate::region_grids::REACH_TEXELS;
use crate::triangles::casters::SceneClusters;

/// Most regions of a world.
const MAX_REGIONS: usize = 1 << 16;

/// A world cut into regions. Look-ups in their files answer as look-ups in one file of the whole world would:
/// all share the voxels, and each file extends beyond the sides of its region as far as filters read.
#[derive(Clone, Debug)]
pub struct RegionPlan {
    frame: Frame,
    voxel_size: f64,
    texels: u32,
    options: BakeOptions,
    /// With the number of triangles in reach, instances counted, the most first.
    regions: Vec<(Region, u64)>,
}

impl RegionPlan {
    /// Texels a side of a region, unless another number is asked for.
    pub const DEFAULT_TEXELS: u32 = 1 << 17;

    /// Cuts the world of `scene` into regions of `texels` texels a side, a power of two. Only those that a
    /// shadow reaches are listed. The frame and the voxel size are chosen as for one bake, but neither the
    /// resolution nor the voxel size has a limit.
    ///
    /// # Errors
    /// Returns [`Error::Range`], [`Error::Resolution`] or [`Error::File`] if an option, `texels` or the
    /// number of regions is out of range or if bounds are given, and [`Error::MemoryLimit`] if the scene does
    /// not fit `max_memory_bytes`.
    pub fn new(scene: &Scene, options: &BakeOptions, texels: u32) -> Result<Self> {
        options.check()?;
        Region::check_texels(texels)?;
        if let Some(bounds) = options.bounds {
            let value = format!("{:?} to {:?}", bounds.min, bounds.max);
            return Err(RangeError::new(
                BakeField::Bounds,
                value,
                "left out where a world is cut into regions",
            )
            .into());
        }
        let options = &BakeOptions { assume_ground: options.assume_ground.decided(scene), ..options.clone() };
        check_sorting(scene, options)?;
        let clusters = SceneClusters::new(scene, caster_options(options));
        let extents = Extents::new(scene, options);
        let voxel_size = options.size.voxel_size(extents.longest_side())?;
        // The forecast that chooses the frame bakes coarsely, whatever the voxel size.
        let forecast = match options.size.resolve(extents.longest_side()) {
            Ok(_) => options.clone(),
            Err(_) => BakeOptions { size: Size::Resolution(FORECAST_RESOLUTION), ..options.clone() },
        };
        let frame = frame(scene, &clusters, &forecast, &extents, &NEVER)?;
        let world = LightGrid::new(options.sun, frame, voxel_size, [0.0; 3], [1; 3]);
        let regions = reached(scene, &clusters, &world, texels)?;
        Ok(Self { frame, voxel_size, texels, options: options.clone(), regions })
    }

    /// Returns the regions, those with the most triangles first.
    pub fn regions(&self) -> impl ExactSizeIterator<Item = Region> {
        self.regions.iter().map(|(region, _)| *region)
    }

    /// Returns one of `shards` shares of the regions with about as many triangles each.
    pub fn shard(&self, shard: usize, shards: usize) -> Vec<Region> {
        self.regions().skip(shard).step_by(shards.max(1)).collect()
    }

    /// Returns the options of the bake of a region's file.
    pub fn options(&self, region: Region) -> BakeOptions {
        BakeOptions {
            frame: match self.frame {
                Frame::Light => FrameChoice::Light,
                Frame::Oblique { yaw_radians } => FrameChoice::ObliqueAt(yaw_radians),
            },
            size: Size::VoxelSize(self.voxel_size),
            region: Some(region),
            ..self.options.clone()
        }
    }

    /// Returns the frame of the grids.
    pub fn frame(&self) -> Frame {
        self.frame
    }

    /// Returns the edge of a voxel of the finest level, in world units.
    pub fn voxel_size(&self) -> f64 {
        self.voxel_size
    }

    /// Returns the texels on a side of each region.
    pub fn texels(&self) -> u32 {
        self.texels
    }
}

/// Resolution of the bake whose frame is forecast for worlds with more texels than a file can have.
const FORECAST_RESOLUTION: u64 = Size::MAX_RESOLUTION as u64;

/// Returns the regions whose look-ups may meet a caster, with the number of triangles of the clusters in
/// reach.
fn reached(
    scene: &Scene,
    clusters: &Arc<SceneClusters>,
    world: &LightGrid,
    texels: u32,
) -> Result<Vec<(Region, u64)>> {
    let side = f64::from(texels);
    let mut counts = BTreeMap::new();
    let mut too_many = false;
    clusters.for_each_extent(scene, world, |[low, high], triangles| {
        let first = [0, 1].map(|a| ((low[a] - REACH_TEXELS) / side).floor());
        let last = [0, 1].map(|a| ((high[a] + REACH_TEXELS) / side).floor());
        let number = (last[0] - first[0] + 1.0) * (last[1] - first[1] + 1.0);
        too_many |= counts.len() > MAX_REGIONS || number > MAX_REGIONS as f64;
        if too_many {
            return;
        }
        for y in first[1] as i32..=last[1] as i32 {
            for x in first[0] as i32..=last[0] as i32 {
                *counts.entry(Region { y, x, texels }).or_insert(0) += triangles;
            }
        }
    });
    if too_many || counts.len() > MAX_REGIONS {
        let value = format!("{} (more than {MAX_REGIONS} regions)", world.voxel_size);
        return Err(Error::Range(RangeError::new(
            BakeField::VoxelSize,
            value,
            "large enough for fewer regions",
        )));
    }
    let mut regions: Vec<_> = counts.into_iter().collect();
    regions.sort_by_key(|&(region, triangles)| (Reverse(triangles), region));
    Ok(regions)
}
