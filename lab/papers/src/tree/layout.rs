//! The cube of a tree, its depth in each part of the plan, and the columns of the light that each part needs.

use crate::tree::error::Result;
use crate::tree::error::{OptionError, TreeOption};
use crate::tree::options::{Detail, TreeOptions};
use crate::tree::space::{RegionVoxels, Regions, TreeSpace};
use crate::tree::word::MAX_DEPTH;
use adumbra::grid::{Bounds, LightExtent, LightGrid};
use adumbra::{MAX_SLOPE, RangeError};
use adumbra_bake::structure::check_bounds;
use adumbra_bake::{BakeField, Size};
use adumbra_scene::Scene;

/// The placement of a tree.
pub(crate) struct Layout {
    pub(crate) space: TreeSpace,
    pub(crate) regions: Regions,
    /// Columns of the light for the space outside all regions, then for each region, deepest first, in the
    /// order of [`Regions::in_voxels`].
    pub(crate) image_grids: Vec<LightGrid>,
}

/// Texels of a depth image along the edge of a voxel of that depth: more than one as long as the image stays
/// small.
fn texels_per_voxel(depth: u32) -> f64 {
    if depth <= 11 { 2.0 } else { 1.0 }
}

/// Determines everything that the depth images need.
///
/// # Errors
/// Returns an error if an option is out of range.
pub(crate) fn lay_out(scene: &Scene, options: &TreeOptions) -> Result<Layout> {
    options.bias.check()?;
    options.capture_bias.check()?;
    options.bounds.as_ref().map_or(Ok(()), check_bounds)?;
    let (space, regions) = divide(scene, options)?;
    let in_voxels = regions.in_voxels(&space);
    check_regions(options, &regions, &in_voxels)?;
    let casters = casters_extent(scene, options);
    let mut image_grids = vec![image_grid(options, &casters, &space, regions.base_depth)];
    for region in &in_voxels {
        let whole = image_grid(options, &casters, &space, region.depth);
        image_grids.push(part_over(&whole, &space, region));
    }
    Ok(Layout { space, regions, image_grids })
}

/// Determines the cube and its depths.
fn divide(scene: &Scene, options: &TreeOptions) -> Result<(TreeSpace, Regions)> {
    let bounds = options.bounds.unwrap_or_else(|| scene.bounds());
    let side = (0..3).map(|a| bounds.max[a] - bounds.min[a]).fold(0.0, f64::max);
    // Casters outside a given box cast into it right up to its rim, so the cube must also contain points that
    // the bias lifts beyond the rim.
    let lift = options.bias.along_light(MAX_SLOPE) + options.bias.normal_offset_texels;
    let margin_voxels = if options.bounds.is_some() { lift.ceil() + 2.0 } else { 0.0 };
    let side = match options.size {
        Size::VoxelSize(size) => side + 2.0 * margin_voxels * size.max(0.0),
        Size::Resolution(n) if n as f64 > 4.0 * margin_voxels => {
            side * n as f64 / (n as f64 - 2.0 * margin_voxels)
        }
        Size::Resolution(_) => side,
    };
    let (resolution, voxel_size) = options.size.resolve(side)?;
    let depth = resolution.ilog2();
    if depth > MAX_DEPTH {
        let (field, value) = match options.size {
            Size::Resolution(n) => (BakeField::Resolution, n.to_string()),
            Size::VoxelSize(size) => (BakeField::VoxelSize, format!("{size} ({resolution} voxels per side)")),
        };
        let range =
            "at most 32768 voxels per side for a world-aligned tree; for more, bake a light-aligned file";
        return Err(adumbra_bake::Error::from(RangeError::new(field, value, range)).into());
    }
    let regions = match &options.detail {
        Detail::Uniform => Regions::uniform(depth),
        Detail::Regions(list) => Regions { base_depth: depth, list: list.clone() },
        Detail::Rings { center_xz, radii } => {
            let growing = radii.windows(2).all(|w| w[0] < w[1]);
            let numbers =
                radii.iter().chain(center_xz).all(|c| c.is_finite()) && radii.iter().all(|r| *r > 0.0);
            if radii.is_empty() || radii.len() as u32 >= depth || !growing || !numbers {
                return Err(OptionError::new(
                    TreeOption::Rings,
                    format!("{center_xz:?} with {radii:?}"),
                    "a point and increasing radii above 0, fewer than the tree has levels",
                )
                .into());
            }
            Regions::rings(*center_xz, radii, depth)
        }
    };
    regions.check()?;
    let finest = regions.depth();
    let center: [f64; 3] = std::array::from_fn(|a| 0.5 * (bounds.min[a] + bounds.max[a]));
    let half_side = 0.5 * voxel_size * f64::from(resolution);
    let space = TreeSpace {
        p_min: center.map(|c| c - half_side),
        voxel_size: voxel_size / f64::from(1_u32 << (finest - depth)),
        depth: finest,
    };
    Ok((space, regions))
}

/// Returns an error if a region would have no effect.
fn check_regions(options: &TreeOptions, regions: &Regions, in_voxels: &[RegionVoxels]) -> Result<()> {
    let (field, range) = match options.detail {
        Detail::Rings { .. } => (TreeOption::Rings, "squares that touch the scene's cube"),
        _ => (TreeOption::Region, "boxes that touch the scene's cube"),
    };
    if in_voxels.len() < regions.list.len() {
        let value = format!("one of {} regions", regions.list.len());
        return Err(OptionError::new(field, value, range).into());
    }
    if let Some(shallow) = regions.list.iter().find(|r| r.depth <= regions.base_depth) {
        let value = format!("a depth of {} (the rest has {})", shallow.depth, regions.base_depth);
        return Err(OptionError::new(field, value, "deeper than the rest of the tree").into());
    }
    Ok(())
}

/// The extent of the casters along the axes of the light.
fn casters_extent(scene: &Scene, options: &TreeOptions) -> LightExtent {
    let mut extent = LightExtent::empty(&options.sun);
    for instance in scene.instances.iter().filter(|i| i.casts) {
        let mesh = &scene.meshes[instance.mesh as usize];
        for &v in mesh.triangles.iter().flatten() {
            extent.add(instance.to_world(mesh.positions[v as usize]));
        }
    }
    extent
}

/// The columns shared by the cube and the casters, with texels sized for voxels of `depth`. The depth range
/// begins where the cube or the casters begin, whichever comes later: surfaces before the cube need not be
/// distinguished.
fn image_grid(options: &TreeOptions, casters: &LightExtent, space: &TreeSpace, depth: u32) -> LightGrid {
    let mut cube = LightExtent::empty(&options.sun);
    let top = space.to_world([f64::from(space.side_voxels()); 3]);
    cube.add_box(&Bounds { min: space.p_min, max: top });
    let voxel_size = space.voxel_size * f64::from(1_u32 << (space.depth - depth));
    let texel = voxel_size / texels_per_voxel(depth);
    let mut common = *casters;
    for a in 0..3 {
        // If they do not overlap, one empty texel remains.
        common.min[a] = casters.min[a].max(cube.min[a]).min(cube.max[a]);
        common.max[a] = casters.max[a].min(cube.max[a]).max(common.min[a] + texel);
    }
    LightGrid::covering(options.sun, &common, texel)
}

/// The columns of `whole` over a region, at all heights, including the cells of the region's depth that
/// extend beyond it.
fn part_over(whole: &LightGrid, space: &TreeSpace, region: &RegionVoxels) -> LightGrid {
    let cell = 1_u32 << (space.depth - region.depth);
    let side = space.side_voxels();
    let range = |[from, to]: [u32; 2]| [from / cell * cell, to.div_ceil(cell).saturating_mul(cell).min(side)];
    let (x, z) = (range(region.x), range(region.z));
    let [mut low, mut high] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for corner in 0..8_usize {
        let pick =
            |axis: usize, [from, to]: [u32; 2]| f64::from(if corner >> axis & 1 == 0 { from } else { to });
        let p = whole.to_grid(space.to_world([pick(0, x), pick(1, [0, side]), pick(2, z)]));
        for a in 0..2 {
            low[a] = low[a].min(p[a]);
            high[a] = high[a].max(p[a]);
        }
    }
    let mut part = *whole;
    let mut corner = [0.0; 3];
    for a in 0..2 {
        let last = f64::from(whole.size[a] - 1);
        let first = low[a].floor().clamp(0.0, last);
        corner[a] = first;
        part.size[a] = (high[a].ceil() - first).clamp(1.0, f64::from(whole.size[a]) - first) as u32;
    }
    for (at, within) in part.corner.iter_mut().zip(corner) {
        *at += within;
    }
    part
}
