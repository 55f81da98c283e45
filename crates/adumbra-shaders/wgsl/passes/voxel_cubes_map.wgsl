// A world-aligned tree's uniform, and its regions as core/voxel_cubes_receiver.wgsl asks for them.

@group(1) @binding(0) var<uniform> cubes: CubesUniform;

fn cubes_plan_edges(axis: u32, index: u32) -> vec4i {
    if (axis == 0u) {
        return cubes.plan.edges_x[index];
    }
    return cubes.plan.edges_z[index];
}

fn cubes_plan_levels(index: u32) -> vec4u {
    return cubes.plan.levels[index];
}

fn cubes_plan_counts() -> vec2u {
    return cubes.plan.counts.xy;
}
