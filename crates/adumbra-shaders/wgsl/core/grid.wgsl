// Transforms relative positions to a voxel grid: integers for the coarse part, floats for the remaining few
// voxels, so that f32 positions lose no precision on grids of 2^18 voxels a side.
// adumbra::gpu::GridParameters computes the coefficients.

struct AdumbraGridPosition {
    // Fixed point; wraps far beyond the grid.
    whole: vec3i,
    // Remainder, a few voxels in either direction.
    rest: vec3f,
    // Sum of both in voxels, rounded.
    voxels: vec3f,
}

fn adumbra_grid_direction(t: AdumbraGridTransform, d: vec3f) -> vec3f {
    return vec3f(dot(t.axis_x, d), dot(t.axis_y, d), dot(t.axis_z, d));
}

// Returns the normal in the grid of a plane with this normal in the world. Its length is different.
fn adumbra_grid_normal(t: AdumbraGridTransform, n: vec3f) -> vec3f {
    return vec3f(dot(t.edge_x, n), dot(t.edge_y, n), dot(t.edge_z, n));
}

fn adumbra_grid_position(t: AdumbraGridTransform, p_relative: vec3f) -> AdumbraGridPosition {
    let steps = round(p_relative * t.steps_per_world);
    // Exact: the step is a power of two.
    let below = p_relative - steps * t.step_world;
    let n = vec3i(steps);
    var g: AdumbraGridPosition;
    g.whole = t.anchor_fixed + n.x * t.step_x + n.y * t.step_y + n.z * t.step_z;
    let left_over = steps.x * t.rest_x + steps.y * t.rest_y + steps.z * t.rest_z;
    g.rest = t.anchor_remainder + left_over + t.voxels_per_world * adumbra_grid_direction(t, below);
    g.voxels = t.anchor_voxels + t.voxels_per_world * adumbra_grid_direction(t, p_relative);
    return g;
}

// Returns the position, moved by some voxels, in fixed point, rounded down. A position far beyond the grid is
// clamped to ADUMBRA_MARGIN_VOXELS beyond it.
fn adumbra_grid_fixed(t: AdumbraGridTransform, g: AdumbraGridPosition, move_voxels: vec3f) -> vec3i {
    let exact = g.whole + vec3i(floor((g.rest + move_voxels) * f32(ADUMBRA_FIXED_ONE)));
    let at = g.voxels + move_voxels;
    let half_margin = vec3f(f32(ADUMBRA_MARGIN_VOXELS / 2));
    let low = vec3i(-ADUMBRA_MARGIN_VOXELS * ADUMBRA_FIXED_ONE);
    let high = (t.size + ADUMBRA_MARGIN_VOXELS) * ADUMBRA_FIXED_ONE;
    let near = select(exact, low, at < -half_margin);
    return select(near, high, at > vec3f(t.size) + half_margin);
}
