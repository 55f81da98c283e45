//! World-to-grid transforms for the shaders: [`GridTransform`] from a grid and an anchor.

use adumbra::gpu::GridParameters;
use adumbra_shaders::layout::GridTransform;

use crate::error::Result;

/// Returns the transform of a grid for positions relative to `anchor_world`. The grid's corner is at `origin`, and its
/// unit `axes` count voxels of `voxel_size`.
///
/// # Errors
/// Returns [`crate::RenderError::Library`] if the grid is too large for look-ups on a GPU.
pub(crate) fn grid_transform(
    origin: [f64; 3],
    axes: [[f64; 3]; 3],
    voxel_size: f64,
    size: [u32; 3],
    anchor_world: [f64; 3],
) -> Result<GridTransform> {
    let g = GridParameters::new(origin, axes, voxel_size, size, anchor_world)?;
    let [axis_x, axis_y, axis_z] = g.axes;
    let [step_x, step_y, step_z] = g.steps;
    let [rest_x, rest_y, rest_z] = g.rests;
    Ok(GridTransform {
        axis_x,
        axis_y,
        axis_z,
        step_x,
        step_y,
        step_z,
        rest_x,
        rest_y,
        rest_z,
        anchor_fixed: g.anchor_fixed,
        anchor_remainder: g.anchor_remainder,
        anchor_voxels: g.anchor_voxels,
        size: g.size,
        voxels_per_world: g.voxels_per_world,
        step_world: g.step_world,
        steps_per_world: g.steps_per_world,
    })
}
