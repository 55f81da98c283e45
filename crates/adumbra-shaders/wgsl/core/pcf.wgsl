// Comparisons with a depth map and their means: percentage-closer filtering.
// Source: Reeves, Salesin, Cook, Rendering Antialiased Shadows with Depth Maps, 1987.
// Departure: each texel is compared with the depth of the receiver's plane at its centre, so a plane never shadows itself however
// wide the filter is, and needs no bias that grows with its slope.

// The texel that the receiver lies in.
fn pcf_nearest(map: texture_depth_2d_array, r: MapReceiver) -> f32 {
    let last = vec2i(textureDimensions(map)) - 1;
    let texel = clamp(vec2i(floor(r.p_texels)), vec2i(0), last);
    let stored = textureLoad(map, texel, r.layer, 0);
    return select(0.0, 1.0, map_plane_depth(r, vec2f(texel) + 0.5) <= stored);
}

// The sampler's own comparison of 2 × 2 texels, which has one depth for all four: that of the plane HARDWARE_REACH texels nearer the sun.
// With 1 no plane would shadow itself, and light would leak further at feet; with less, texels of little weight do.
fn pcf_hardware(map: texture_depth_2d_array, comparing: sampler_comparison, r: MapReceiver) -> f32 {
    let size = f32(textureDimensions(map).x);
    let depth = clamp(r.depth - HARDWARE_REACH * (abs(r.gradient.x) + abs(r.gradient.y)), 0.0, 1.0);
    return textureSampleCompareLevel(map, comparing, r.p_texels / size, r.layer, depth);
}

// The mean over a square of `width` - 1 texels around the receiver: up to `width` × `width` texels, those at its border by the part
// that lies inside. Width 2 is bilinear. Reads four texels at a time: 1, 4, 9 or 16 gathers for 2, 3, 5 or 7.
fn pcf_box(map: texture_depth_2d_array, gathering: sampler, r: MapReceiver, width: u32) -> f32 {
    let size = f32(textureDimensions(map).x);
    let half_side = 0.5 * (f32(width) - 1.0);
    let low = r.p_texels - half_side;
    let high = r.p_texels + half_side;
    let pairs = (width + 1u) / 2u;
    var lit = 0.0;
    for (var y = 0u; y < pairs; y++) {
        for (var x = 0u; x < pairs; x++) {
            // The corner that four texels share.
            let corner = floor(low) + 2.0 * vec2f(vec2u(x, y)) + 1.0;
            let stored = textureGather(map, gathering, corner / size, r.layer);
            let middle = r.depth + dot(r.gradient, corner - r.p_texels);
            let right = 0.5 * r.gradient.x;
            let down = 0.5 * r.gradient.y;
            // In the gather's order: below left, below right, above right, above left.
            let plane = vec4f(middle - right + down, middle + right + down, middle + right - down, middle - right - down);
            let passed = select(vec4f(0.0), vec4f(1.0), min(plane, vec4f(r.deepest)) <= stored);
            let columns = map_overlap(vec2f(corner.x - 1.0, corner.x), vec2f(low.x, high.x));
            let rows = map_overlap(vec2f(corner.y - 1.0, corner.y), vec2f(low.y, high.y));
            lit += dot(passed, vec4f(columns.x, columns.y, columns.y, columns.x) * rows.yyxx);
        }
    }
    return lit / (4.0 * half_side * half_side);
}

// The mean of the first `taps` bilinear taps of a disc.
fn pcf_disc(
    map: texture_depth_2d_array,
    gathering: sampler,
    r: MapReceiver,
    radius_texels: f32,
    taps: u32,
    turn: vec2f,
) -> f32 {
    var lit = 0.0;
    for (var i = 0u; i < taps; i++) {
        lit += pcf_box(map, gathering, map_moved(r, radius_texels * disc_tap(i, turn)), 2u);
    }
    return lit / f32(taps);
}
