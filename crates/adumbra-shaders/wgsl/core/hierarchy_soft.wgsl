// Penumbrae of a sun with a size, from the depths of a hierarchy: as wide as the cone of the sun is at the blockers' mean distance.
// Source: Fernando, Percentage-Closer Soft Shadows, 2005; the cone for a sun as in core/pcss.wgsl. Voxels are cubes, so a radius in texels
// is the cone's tangent times a distance in voxels. Places are whole numbers, so that large grids lose nothing.

// How far before the receiver, fixed point, the column's switch lies; negative where the column is lit at the depth of the receiver's plane.
// No comparison is with a depth behind the receiver's own: beyond a crease the plane runs below the surface, which would shadow it.
fn hierarchy_blocker(v: VoxelParams, r: VoxelReceiver, texel: vec2i) -> i32 {
    let own = r.p_fixed.z >> FIXED_BITS;
    let layer = min(voxel_layer(r, texel), own);
    if (any(texel < vec2i(0)) || any(texel >= v.grid.size.xy) || layer < 0) {
        return -1;
    }
    let value = hierarchy_value(v, vec2u(texel));
    if (u32(min(layer, v.grid.size.z - 1)) < value) {
        return -1;
    }
    return max(r.p_fixed.z - i32(value) * FIXED_ONE, 0);
}

// Mean distance of blockers in voxels; negative where there are none. Taps are denser towards the middle, where near blockers count alone.
fn hierarchy_blocker_distance(v: VoxelParams, r: VoxelReceiver, cone: f32, max_radius: f32, turn: vec2f) -> f32 {
    // Nothing lies before depth 0.
    let search = clamp(cone * f32(r.p_fixed.z) / f32(FIXED_ONE), 1.0, max_radius);
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < 32u; i++) {
        let tap = disc_tap(i, turn);
        let offset = search * length(tap) * tap;
        let place = r.p_fixed.xy + vec2i(floor(offset * f32(FIXED_ONE)));
        let distance = f32(hierarchy_blocker(v, r, place >> vec2u(FIXED_BITS))) / f32(FIXED_ONE);
        if (distance >= 0.0 && length(offset) <= max(cone * distance, 1.0)) {
            sum += distance;
            count += 1.0;
        }
    }
    return select(-1.0, sum / max(count, 1.0), count > 0.0);
}

// Bilinear mean of the four columns around a place.
fn hierarchy_bilinear(v: VoxelParams, r: VoxelReceiver, place: vec2i) -> f32 {
    let low = place - FIXED_ONE / 2;
    let corner = low >> vec2u(FIXED_BITS);
    let share = vec2f(low & vec2i(FIXED_ONE - 1)) / f32(FIXED_ONE);
    var lit = vec4f(0.0);
    for (var i = 0; i < 4; i++) {
        lit[i] = select(0.0, 1.0, hierarchy_blocker(v, r, corner + vec2i(i & 1, i >> 1u)) < 0);
    }
    let rows = mix(lit.xz, lit.yw, share.x);
    return mix(rows.x, rows.y, share.y);
}

// Visibility of the sun's disc. `cone`: texels that the sun's cone widens by a voxel of depth.
fn hierarchy_soft(v: VoxelParams, r: VoxelReceiver, cone: f32, max_radius: f32, turn: vec2f) -> f32 {
    let distance = hierarchy_blocker_distance(v, r, cone, max_radius, turn);
    if (distance < 0.0) {
        return 1.0;
    }
    // Bilinear taps are a texel wide themselves.
    let radius = clamp(cone * distance, 0.5, max_radius);
    var lit = 0.0;
    for (var i = 0u; i < 32u; i++) {
        let offset = radius * disc_tap(i, turn);
        lit += hierarchy_bilinear(v, r, r.p_fixed.xy + vec2i(floor(offset * f32(FIXED_ONE))));
    }
    return lit / 32.0;
}
