//! World-to-grid transforms as the shaders' structure.

use adumbra::gpu::GridParameters;
use adumbra_shaders::layout::GridTransform;

/// Returns the structure for shaders.
pub fn grid_transform(g: &GridParameters) -> GridTransform {
    let [axis_x, axis_y, axis_z] = g.axes;
    let [edge_x, edge_y, edge_z] = g.edges;
    let [step_x, step_y, step_z] = g.steps;
    let [rest_x, rest_y, rest_z] = g.rests;
    GridTransform {
        axis_x,
        axis_y,
        axis_z,
        edge_x,
        edge_y,
        edge_z,
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
    }
}
