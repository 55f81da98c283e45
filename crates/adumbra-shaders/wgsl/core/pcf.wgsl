// Comparisons with a depth map and their means: percentage-closer filtering. Source: Reeves, Salesin, Cook,
// Rendering Antialiased Shadows with Depth Maps, 1987. Departure: each texel is compared with the depth of
// the receiver's plane at the texel's centre. A plane therefore never shadows itself, however wide the
// filter, and no bias that grows with the slope is needed.

// Compares the texel that contains the receiver.
fn adumbra_pcf_nearest(map: texture_depth_2d_array, r: AdumbraMapReceiver) -> f32 {
    let last = vec2i(textureDimensions(map)) - 1;
    let texel = clamp(vec2i(floor(r.p_texels)), vec2i(0), last);
    let stored = textureLoad(map, texel, r.layer, 0);
    return select(0.0, 1.0, adumbra_map_plane_depth(r, vec2f(texel) + 0.5) <= stored);
}

// The sampler's own comparison of 2 × 2 texels, which uses one depth for all four: that of the plane, moved
// towards the sun by its change over ADUMBRA_HARDWARE_REACH texels. With a reach of 1 no plane would shadow
// itself, but more light would leak in where objects touch the ground. With less, texels of small weight do
// shadow.
fn adumbra_pcf_hardware(map: texture_depth_2d_array, comparing: sampler_comparison, r: AdumbraMapReceiver) -> f32 {
    let size = f32(textureDimensions(map).x);
    let depth = clamp(r.depth - ADUMBRA_HARDWARE_REACH * (abs(r.gradient.x) + abs(r.gradient.y)), 0.0, 1.0);
    return textureSampleCompareLevel(map, comparing, r.p_texels / size, r.layer, depth);
}

// Returns the mean over a square of `width` - 1 texels around the receiver: up to `width` × `width` texels,
// with those at the border weighted by the part that is inside. Width 2 is bilinear. Reads four texels at a
// time: 1, 4, 9 or 16 gathers for width 2, 3, 5 or 7.
fn adumbra_pcf_box(map: texture_depth_2d_array, gathering: sampler, r: AdumbraMapReceiver, width: u32) -> f32 {
    let size = f32(textureDimensions(map).x);
    let half_side = 0.5 * (f32(width) - 1.0);
    let low = r.p_texels - half_side;
    let high = r.p_texels + half_side;
    let pairs = (width + 1u) / 2u;
    var lit = 0.0;
    for (var y = 0u; y < pairs; y++) {
        for (var x = 0u; x < pairs; x++) {
            // The corner shared by the four gathered texels.
            let corner = floor(low) + 2.0 * vec2f(vec2u(x, y)) + 1.0;
            let stored = textureGather(map, gathering, corner / size, r.layer);
            let middle = r.depth + dot(r.gradient, corner - r.p_texels);
            let right = 0.5 * r.gradient.x;
            let down = 0.5 * r.gradient.y;
            // In gather order: lower left, lower right, upper right, upper left.
            let plane = vec4f(middle - right + down, middle + right + down, middle + right - down, middle - right - down);
            let passed = select(vec4f(0.0), vec4f(1.0), min(plane, vec4f(r.deepest)) <= stored);
            let columns = adumbra_map_overlap(vec2f(corner.x - 1.0, corner.x), vec2f(low.x, high.x));
            let rows = adumbra_map_overlap(vec2f(corner.y - 1.0, corner.y), vec2f(low.y, high.y));
            lit += dot(passed, vec4f(columns.x, columns.y, columns.y, columns.x) * rows.yyxx);
        }
    }
    return lit / (4.0 * half_side * half_side);
}

// Returns the mean of the first `taps` bilinear taps of a disc.
fn adumbra_pcf_disc(
    map: texture_depth_2d_array,
    gathering: sampler,
    r: AdumbraMapReceiver,
    radius_texels: f32,
    taps: u32,
    turn: vec2f,
) -> f32 {
    var lit = 0.0;
    for (var i = 0u; i < taps; i++) {
        lit += adumbra_pcf_box(map, gathering, adumbra_map_moved(r, radius_texels * adumbra_disc_tap(i, turn)), 2u);
    }
    return lit / f32(taps);
}
