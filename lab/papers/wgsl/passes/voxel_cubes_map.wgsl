// A world-aligned tree's uniform, and the accessors to its regions that core/voxel_cubes_receiver.wgsl
// expects.

@group(1) @binding(0) var<uniform> cubes: AdumbraCubesUniform;

fn adumbra_cubes_plan_edges(axis: u32, index: u32) -> vec4i {
    if (axis == 0u) {
        return cubes.plan.edges_x[index];
    }
    return cubes.plan.edges_z[index];
}

fn adumbra_cubes_plan_levels(index: u32) -> vec4u {
    return cubes.plan.levels[index];
}

fn adumbra_cubes_plan_counts() -> vec2u {
    return vec2u(cubes.plan.edge_count_x, cubes.plan.edge_count_z);
}
