// From relative positions to a grid of voxels: whole numbers for the coarse part, floats for the few voxels left over, so that
// f32 positions lose nothing on grids of 2^18 voxels a side. Filled in by adumbra-render's voxel/grid.rs.

struct GridPosition {
    // Fixed point; wraps far beyond the grid.
    whole: vec3i,
    // What it leaves over, a few voxels either way.
    rest: vec3f,
    // Both together in voxels, rounded.
    voxels: vec3f,
}

fn grid_direction(t: GridTransform, d: vec3f) -> vec3f {
    return vec3f(dot(t.axis_x.xyz, d), dot(t.axis_y.xyz, d), dot(t.axis_z.xyz, d));
}

fn grid_position(t: GridTransform, p_relative: vec3f) -> GridPosition {
    let steps = round(p_relative * t.scale.z);
    // Exact: the step is a power of two.
    let below = p_relative - steps * t.scale.y;
    let n = vec3i(steps);
    var g: GridPosition;
    g.whole = t.anchor_fixed.xyz + n.x * t.step_x.xyz + n.y * t.step_y.xyz + n.z * t.step_z.xyz;
    let left_over = steps.x * t.rest_x.xyz + steps.y * t.rest_y.xyz + steps.z * t.rest_z.xyz;
    let anchor_rest = vec3f(t.axis_x.w, t.axis_y.w, t.axis_z.w);
    g.rest = anchor_rest + left_over + t.scale.x * grid_direction(t, below);
    g.voxels = t.anchor_voxels.xyz + t.scale.x * grid_direction(t, p_relative);
    return g;
}

// Fixed point, rounded down, of a position moved by some voxels. Far beyond the grid it stands MARGIN_VOXELS beyond it.
fn grid_fixed(t: GridTransform, g: GridPosition, move_voxels: vec3f) -> vec3i {
    let exact = g.whole + vec3i(floor((g.rest + move_voxels) * f32(FIXED_ONE)));
    let at = g.voxels + move_voxels;
    let half_margin = vec3f(f32(MARGIN_VOXELS / 2));
    let low = vec3i(-MARGIN_VOXELS * FIXED_ONE);
    let high = (t.size.xyz + MARGIN_VOXELS) * FIXED_ONE;
    let near = select(exact, low, at < -half_margin);
    return select(near, high, at > vec3f(t.size.xyz) + half_margin);
}
