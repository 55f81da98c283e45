//! The grids of a region of a world.

use adumbra::file::LEVEL_STEP;
use adumbra::{Frame, LightGrid, RangeError, Region};
use adumbra_scene::Scene;

use crate::error::{BakeField, Result};
use crate::options::{BakeOptions, FrameChoice, Size};
use crate::plan::{Placement, lattice_step};
use crate::triangles::casters::SceneClusters;

/// How far beyond its sides, in texels of any level, a region's look-ups may read: half of the widest filter,
/// and what the normal offset of the bias may add. Pages beyond the sides have at least as many.
pub(crate) const REACH_TEXELS: f64 = 32.0;

/// Places the grids of all levels of a region: its columns, and the pages that its filters reach.
///
/// # Errors
/// Returns [`Error::Range`](crate::Error::Range) if the options have no frame or no voxel size, and if the
/// grid has too many voxels along the light.
pub(crate) fn placements(
    scene: &Scene,
    clusters: &SceneClusters,
    options: &BakeOptions,
    region: Region,
) -> Result<Vec<Placement>> {
    let (frame, Size::VoxelSize(voxel_size)) = (
        match options.frame {
            FrameChoice::Light => Frame::Light,
            FrameChoice::ObliqueAt(yaw_radians) => Frame::Oblique { yaw_radians },
            FrameChoice::Oblique | FrameChoice::Auto => return Err(not_shared("a frame without a yaw")),
        },
        options.size,
    ) else {
        return Err(not_shared("a resolution"));
    };
    let world = LightGrid::new(options.sun, frame, voxel_size, [0.0; 3], [1; 3]);
    let levels = options.level_count(region.texels);
    let beyond = REACH_TEXELS * f64::from(LEVEL_STEP.pow(levels - 1));
    let [z_low, z_high] = depths(scene, clusters, &world, region, beyond);
    let lattice_step = lattice_step(region.texels);
    let place = |level: u32| {
        let step = LEVEL_STEP.pow(level);
        let texels = region.texels / step;
        let scale = f64::from(step);
        let [x, y] = region.first_texel().map(|first| first / scale - REACH_TEXELS);
        // A margin of one voxel before the first surface and behind the last.
        let corner = [x, y, (z_low / scale).floor() - 1.0];
        let side = texels + 2 * REACH_TEXELS as u32;
        let depth = ((z_high / scale).ceil() + 1.0 - corner[2]).clamp(1.0, f64::from(u32::MAX)) as u32;
        let grid = LightGrid::new(options.sun, frame, voxel_size * scale, corner, [side, side, depth]);
        Placement::on(grid.snapped_to(lattice_step), texels, options)
    };
    (0..levels).map(place).collect()
}

fn not_shared(value: &str) -> crate::Error {
    RangeError::new(
        BakeField::VoxelSize,
        value,
        "one that all regions share, as RegionPlan::options returns it",
    )
    .into()
}

/// Returns the depths between which the casters are over a region and up to `beyond_texels` beside it, in
/// voxels of the finest level.
fn depths(
    scene: &Scene,
    clusters: &SceneClusters,
    world: &LightGrid,
    region: Region,
    beyond_texels: f64,
) -> [f64; 2] {
    let first = region.first_texel().map(|first| first - beyond_texels);
    let end = region.first_texel().map(|first| first + f64::from(region.texels) + beyond_texels);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    clusters.for_each_extent(scene, world, |[from, to], _| {
        if (0..2).all(|a| from[a] <= end[a] && to[a] >= first[a]) {
            low = low.min(from[2]);
            high = high.max(to[2]);
        }
    });
    if low <= high { [low, high] } else { [0.0, 0.0] }
}
