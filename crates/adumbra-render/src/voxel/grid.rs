//! World to grid for the shaders: [`GridTransform`] from a grid and an anchor, in `f64`.

use adumbra::query::{FIXED_ONE, MAX_FIXED_SIDE};
use adumbra_shaders::layout::GridTransform;

use crate::error::{RenderError, Result};

/// Most voxels that a step spans.
const STEP_VOXELS: f64 = 8.0;

/// The transform of a grid whose corner lies at `origin` and whose unit `axes` count voxels of `voxel_size`, for positions relative to
/// `anchor_world`.
///
/// # Errors
/// [`RenderError::VoxelLimit`] for a side of more than [`MAX_FIXED_SIDE`] voxels.
pub fn grid_transform(
    origin: [f64; 3],
    axes: [[f64; 3]; 3],
    voxel_size: f64,
    size: [u32; 3],
    anchor_world: [f64; 3],
) -> Result<GridTransform> {
    let longest = size.into_iter().fold(0, u32::max);
    if longest > MAX_FIXED_SIDE {
        return Err(RenderError::VoxelLimit {
            what: "the grid's longest side in voxels",
            value: longest.into(),
            limit: MAX_FIXED_SIDE.into(),
            mend: "bake at a lower --resolution",
        });
    }
    // A power of two, so that the shader's products with it are exact.
    let step_world = (STEP_VOXELS * voxel_size).log2().floor().exp2();
    let steps: [([i32; 4], [f32; 4]); 3] =
        std::array::from_fn(|world| split(axes.map(|axis| axis[world] * step_world / voxel_size)));
    let from_corner: [f64; 3] = std::array::from_fn(|a| anchor_world[a] - origin[a]);
    let anchor = axes.map(|axis| (0..3).map(|a| axis[a] * from_corner[a]).sum::<f64>() / voxel_size);
    let (anchor_fixed, anchor_rest) = split(anchor);
    let row = |a: usize| [axes[a][0] as f32, axes[a][1] as f32, axes[a][2] as f32, anchor_rest[a]];
    let wide = |v: [f64; 3]| [v[0] as f32, v[1] as f32, v[2] as f32, 0.0];
    let [x, y, z] = steps;
    Ok(GridTransform {
        axis_x: row(0),
        axis_y: row(1),
        axis_z: row(2),
        step_x: x.0,
        step_y: y.0,
        step_z: z.0,
        rest_x: x.1,
        rest_y: y.1,
        rest_z: z.1,
        anchor_fixed,
        anchor_voxels: wide(anchor),
        scale: [(1.0 / voxel_size) as f32, step_world as f32, (1.0 / step_world) as f32, 0.0],
        size: [size[0] as i32, size[1] as i32, size[2] as i32, 0],
    })
}

/// Fixed point, wrapped, and what it leaves over in voxels.
fn split(voxels: [f64; 3]) -> ([i32; 4], [f32; 4]) {
    let one = f64::from(FIXED_ONE);
    let whole = voxels.map(|v| (v * one).floor());
    let rest = [0, 1, 2].map(|a| ((voxels[a] * one - whole[a]) / one) as f32);
    // The shader adds modulo 2^32.
    let [x, y, z] = whole.map(|w| w as i64 as i32);
    ([x, y, z, 0], [rest[0], rest[1], rest[2], 0.0])
}

#[cfg(test)]
mod tests {
    use adumbra::light::{LightExtent, LightGrid, Sun};
    use adumbra::scene::Bounds;
    use adumbra::verify::Random;

    use super::*;

    /// What core/grid.wgsl makes of it, in f32: whole part and rest in voxels.
    fn shader(t: &GridTransform, p: [f32; 3]) -> [f64; 3] {
        let steps = p.map(|c| (c * t.scale[2]).round_ties_even());
        let below: [f32; 3] = std::array::from_fn(|a| p[a] - steps[a] * t.scale[1]);
        let n = steps.map(|s| s as i32);
        let axes = [t.axis_x, t.axis_y, t.axis_z];
        std::array::from_fn(|a| {
            let products =
                [t.step_x[a], t.step_y[a], t.step_z[a]].into_iter().zip(n).map(|(s, n)| s.wrapping_mul(n));
            let whole = products.fold(t.anchor_fixed[a], i32::wrapping_add);
            let left_over = steps[0] * t.rest_x[a] + steps[1] * t.rest_y[a] + steps[2] * t.rest_z[a];
            let low = axes[a][0] * below[0] + axes[a][1] * below[1] + axes[a][2] * below[2];
            let rest = axes[a][3] + left_over + t.scale[0] * low;
            f64::from(whole) / f64::from(FIXED_ONE) + f64::from(rest)
        })
    }

    #[test]
    fn grid_transform_loses_nothing_on_the_largest_grids() {
        let sun = Sun::from_angles(217.0, 34.0).unwrap();
        let bounds = Bounds { min: [-700.0, -3.0, 200.0], max: [900.0, 150.0, 1900.0] };
        let mut extent = LightExtent::empty(&sun);
        extent.add_box(&bounds);
        let mut random = Random::new(3, 0);
        for resolution in [1024.0, 16384.0, 262_144.0] {
            let grid = LightGrid::covering(sun, &extent, extent.longest_side() / resolution);
            for anchor in [[100.0, 75.0, 1050.0], [-700.0, 1.7, 1900.0]] {
                let t = grid_transform(grid.origin, grid.axes, grid.voxel_size, grid.size, anchor).unwrap();
                let mut worst = 0.0_f64;
                for _ in 0..20_000 {
                    let p: [f32; 3] = std::array::from_fn(|a| {
                        let share = random.unit();
                        (bounds.min[a] + share * (bounds.max[a] - bounds.min[a]) - anchor[a]) as f32
                    });
                    let exact = grid.to_grid(std::array::from_fn(|a| anchor[a] + f64::from(p[a])));
                    let found = shader(&t, p);
                    worst = (0..3).map(|a| (found[a] - exact[a]).abs()).fold(worst, f64::max);
                }
                assert!(worst < 1e-5, "{resolution}: {worst} voxels");
            }
        }
    }

    #[test]
    fn grid_too_long_for_fixed_point_is_refused() {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let side = MAX_FIXED_SIDE + 1;
        let refused = grid_transform([0.0; 3], axes, 1.0, [8, 8, side], [0.0; 3]);
        assert!(matches!(refused, Err(RenderError::VoxelLimit { value, .. }) if value == u64::from(side)));
    }
}
