// The techniques `voxel-cubes` and `voxel-texture`: a world-aligned tree, filtered over 1, 3³ or 5³ cells.

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

fn shadow_factor(s: Surface) -> f32 {
    return cubes_factor(cubes.params, s);
}
