// What all statistics of depth share. A kind of them (vsm, evsm or msm.wgsl) defines
//     alias MomentsOut                                          the storage texture that holds them
//     fn moments_of(depth: f32, exponents: vec2f) -> vec4f      of one depth
//     fn moments_visibility(m: vec4f, depth: f32, deviation: f32, params: vec4f) -> f32
// where `deviation` is the least standard deviation in depth units and `params` is MapParams.moments.

// Chebyshev's upper bound on the share of depths at or behind t, given mean and mean square; its tail below `bleed` is cut off, and the
// rest stretched. Source: Donnelly, Lauritzen, Variance Shadow Maps, 2006; the cut: Lauritzen, Summed-Area Variance Shadow Maps, 2007.
fn moments_chebyshev(m: vec2f, t: f32, least_variance: f32, bleed: f32) -> f32 {
    if (t <= m.x) {
        return 1.0;
    }
    // Neither rounding nor an asked deviation of 0 makes it 0 / 0.
    let variance = max(m.y - m.x * m.x, max(least_variance, 1e-12));
    let behind = t - m.x;
    return moments_cut(variance / (variance + behind * behind), bleed);
}

fn moments_cut(bound: f32, bleed: f32) -> f32 {
    return clamp((bound - bleed) / (1.0 - bleed), 0.0, 1.0);
}

// Bilinear, from the first mip level.
fn moments_loaded(moments: texture_2d_array<f32>, r: MapReceiver) -> vec4f {
    let last = vec2i(textureDimensions(moments)) - 1;
    let p = r.p_texels - 0.5;
    let corner = floor(p);
    let part = p - corner;
    let low = clamp(vec2i(corner), vec2i(0), last);
    let high = clamp(vec2i(corner) + 1, vec2i(0), last);
    let above = mix(
        textureLoad(moments, low, r.layer, 0),
        textureLoad(moments, vec2i(high.x, low.y), r.layer, 0),
        part.x,
    );
    let below = mix(
        textureLoad(moments, vec2i(low.x, high.y), r.layer, 0),
        textureLoad(moments, high, r.layer, 0),
        part.x,
    );
    return mix(above, below, part.y);
}

// Mip level whose texels are as large as a pixel at this view depth; `pixel` as in MapParams.
fn moments_level(pixel: vec4f, layer: MapLayer, view_depth: f32) -> f32 {
    let pixel_world = pixel.x + pixel.y * max(view_depth, 0.0);
    return clamp(log2(max(pixel_world / layer.scale.x, 1.0)), 0.0, pixel.z - 1.0);
}
