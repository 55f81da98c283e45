//! The parameter block written by `adumbra::gpu` must match the structure that the shaders read.

use adumbra::Bias;
use adumbra::gpu::{GridParameters, Parameters};
use adumbra_shaders::layout::{GpuType, GridTransform, ReceiverBias, VoxelParams};

#[test]
fn parameter_block_matches_shared_structure_bytes() {
    let grid = GridParameters {
        axes: [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]],
        edges: [[1.5, 2.5, 3.5], [4.5, 5.5, 6.5], [7.5, 8.5, 9.5]],
        steps: [[10, 11, 12], [13, 14, 15], [16, 17, -18]],
        rests: [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6], [0.7, 0.8, 0.9]],
        anchor_fixed: [-19, 20, 21],
        anchor_remainder: [0.11, 0.12, 0.13],
        anchor_voxels: [22.0, 23.0, 24.0],
        size: [25, 26, 27],
        voxels_per_world: 28.0,
        step_world: 29.0,
        steps_per_world: 30.0,
    };
    let [axis_x, axis_y, axis_z] = grid.axes;
    let [edge_x, edge_y, edge_z] = grid.edges;
    let [step_x, step_y, step_z] = grid.steps;
    let [rest_x, rest_y, rest_z] = grid.rests;
    let shared = GridTransform {
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
        anchor_fixed: grid.anchor_fixed,
        anchor_remainder: grid.anchor_remainder,
        anchor_voxels: grid.anchor_voxels,
        size: grid.size,
        voxels_per_world: grid.voxels_per_world,
        step_world: grid.step_world,
        steps_per_world: grid.steps_per_world,
    };
    let parameters = Parameters {
        grid,
        root_count: [31, 32, 33],
        root_level: 34,
        bias: Bias { constant_texels: 0.25, slope_texels: 0.5, normal_offset_texels: 0.75 },
        table_offset: 37,
        coarser_levels: 2,
        may_lack_pages: true,
        pages_fade: true,
        code_offset: 36,
        filter_width: 9,
        sun_cone: 0.01,
        max_radius_texels: 64.0,
        penumbra: [[0.25, 0.5], [0.75, 1.25]],
    };
    let expected = VoxelParams {
        grid: shared,
        root_count: [31, 32, 33],
        root_level: 34,
        bias: ReceiverBias {
            constant_texels: 0.25,
            slope_texels: 0.5,
            normal_offset_texels: 0.75,
            width_factor: 1.0,
        },
        extra: [37, 2, 2],
        code_offset: 36,
        filter_width: 9,
        sun_cone: 0.01,
        max_radius_texels: 64.0,
        penumbra_x: [0.25, 0.5],
        penumbra_y: [0.75, 1.25],
    };
    let mut bytes = Vec::new();
    expected.put(&mut bytes);
    assert_eq!(bytes.len(), Parameters::BYTES);
    assert_eq!(parameters.to_bytes()[..], bytes[..]);
}
