// Penumbrae of an area sun from the switch depths of a light-aligned file. A penumbra is as wide as the sun's
// cone at the mean distance of the blockers. Source: Fernando, Percentage-Closer Soft Shadows, 2005; the cone
// for the sun as in core/pcss.wgsl. A radius in texels is the cone's growth per voxel of depth times a
// distance in voxels. In the oblique frame the cone's outline is an ellipse; discs are turned into it where
// they meet the grid. Positions are integers, so that no precision is lost on large grids.

// Returns the fixed-point grid position at an offset on the disc across the light, in texels.
fn adumbra_depths_disc(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver, offset: vec2f) -> vec2i {
    let texels = vec2f(dot(v.penumbra_x, offset), dot(v.penumbra_y, offset));
    return r.p_fixed.xy + vec2i(floor(texels * f32(ADUMBRA_FIXED_ONE)));
}

// Returns how far in front of the receiver the column switches, fixed point; negative if the column is lit at
// the depth of the receiver's plane. The compared depth is never behind the receiver's own: beyond a crease
// the plane continues below the surface, which would then shadow it.
fn adumbra_depths_blocker(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver, texel: vec2i) -> i32 {
    let own = r.p_fixed.z >> ADUMBRA_FIXED_BITS;
    let layer = min(adumbra_voxel_layer(r, texel), own);
    if (any(texel < vec2i(0)) || any(texel >= v.grid.size.xy) || layer < 0) {
        return -1;
    }
    let value = adumbra_depths_value(v, vec2u(texel));
    if (u32(min(layer, v.grid.size.z - 1)) < value) {
        return -1;
    }
    return max(r.p_fixed.z - i32(value) * ADUMBRA_FIXED_ONE, 0);
}

// Returns the mean distance of the blockers in voxels; negative if there are none. Taps are denser towards
// the centre, the only place where near blockers count.
fn adumbra_depths_blocker_distance(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver, turn: vec2f) -> f32 {
    let cone = v.sun_cone;
    // Nothing is in front of depth 0.
    let search = clamp(cone * f32(r.p_fixed.z) / f32(ADUMBRA_FIXED_ONE), 1.0, v.max_radius_texels);
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < 32u; i++) {
        let tap = adumbra_disc_tap(i, turn);
        let offset = search * length(tap) * tap;
        let tap_fixed = adumbra_depths_disc(v, r, offset);
        let distance = f32(adumbra_depths_blocker(v, r, tap_fixed >> vec2u(ADUMBRA_FIXED_BITS))) / f32(ADUMBRA_FIXED_ONE);
        if (distance >= 0.0 && length(offset) <= max(cone * distance, 1.0)) {
            sum += distance;
            count += 1.0;
        }
    }
    return select(-1.0, sum / max(count, 1.0), count > 0.0);
}

// Returns the bilinear mean over the four columns around a fixed-point position.
fn adumbra_depths_bilinear(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver, p_fixed: vec2i) -> f32 {
    let low = p_fixed - ADUMBRA_FIXED_ONE / 2;
    let corner = low >> vec2u(ADUMBRA_FIXED_BITS);
    let share = vec2f(low & vec2i(ADUMBRA_FIXED_ONE - 1)) / f32(ADUMBRA_FIXED_ONE);
    var lit = vec4f(0.0);
    for (var i = 0; i < 4; i++) {
        lit[i] = select(0.0, 1.0, adumbra_depths_blocker(v, r, corner + vec2i(i & 1, i >> 1u)) < 0);
    }
    let rows = mix(lit.xz, lit.yw, share.x);
    return mix(rows.x, rows.y, share.y);
}

// Whether all pages are resident that the search for blockers and the taps may read.
fn adumbra_depths_are_resident(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver) -> bool {
    let reach = vec2i(v.max_radius_texels * vec2f(length(v.penumbra_x), length(v.penumbra_y))) + 2;
    let texel = r.p_fixed.xy >> vec2u(ADUMBRA_FIXED_BITS);
    let low = max(texel - reach, vec2i(0)) >> vec2u(v.root_level);
    let high = min(texel + reach, v.grid.size.xy - 1) >> vec2u(v.root_level);
    for (var y = low.y; y <= high.y; y++) {
        for (var x = low.x; x <= high.x; x++) {
            let entry = v.extra.x + 2u * (u32(y) * v.root_count.x + u32(x));
            if (adumbra_voxel_word(entry) == ADUMBRA_DEPTHS_ABSENT) {
                return false;
            }
        }
    }
    return true;
}

// Returns the visibility of the sun's disc; -1 if a page that it may need is not resident.
fn adumbra_depths_soft(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver, turn: vec2f) -> f32 {
    if (v.extra.z != 0u && !adumbra_depths_are_resident(v, r)) {
        return -1.0;
    }
    let distance = adumbra_depths_blocker_distance(v, r, turn);
    if (distance < 0.0) {
        return 1.0;
    }
    // The footprint of a bilinear tap is itself one texel wide.
    let radius = clamp(v.sun_cone * distance, 0.5, v.max_radius_texels);
    var lit = 0.0;
    for (var i = 0u; i < 32u; i++) {
        let offset = radius * adumbra_disc_tap(i, turn);
        lit += adumbra_depths_bilinear(v, r, adumbra_depths_disc(v, r, offset));
    }
    return lit / 32.0;
}
