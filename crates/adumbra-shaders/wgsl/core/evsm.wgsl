// Exponential variance shadow maps: the variance bound on two warps of depth, of which the smaller counts.
// Source: Lauritzen, McCool, Layered Variance Shadow Maps, 2008. Depth from -1 to 1; exponents up to 42 fit 32-bit floats, squares too.

alias MomentsOut = texture_storage_2d<rgba32float, write>;

fn evsm_warp(depth: f32, exponents: vec2f) -> vec2f {
    let t = 2.0 * depth - 1.0;
    return vec2f(exp(exponents.x * t), -exp(-exponents.y * t));
}

fn moments_of(depth: f32, exponents: vec2f) -> vec4f {
    let w = evsm_warp(depth, exponents);
    return vec4f(w.x, w.x * w.x, w.y, w.y * w.y);
}

fn moments_visibility(m: vec4f, depth: f32, deviation: f32, params: vec4f) -> f32 {
    let w = evsm_warp(depth, params.zw);
    // The deviation, as the warp's slope stretches it there.
    let stretched = 2.0 * deviation * params.zw * w;
    let positive = moments_chebyshev(m.xy, w.x, stretched.x * stretched.x, params.y);
    let negative = moments_chebyshev(m.zw, w.y, stretched.y * stretched.y, params.y);
    return min(positive, negative);
}
