// Exponential variance shadow maps: the smaller of the variance bounds on two warps of depth.
// Source: Lauritzen, McCool, Layered Variance Shadow Maps, 2008.
// Depth is from -1 to 1. With exponents up to 42, the warps and their squares fit in 32-bit floats.

alias AdumbraMomentsOut = texture_storage_2d<rgba32float, write>;

fn adumbra_evsm_warp(depth: f32, exponents: vec2f) -> vec2f {
    let t = 2.0 * depth - 1.0;
    return vec2f(exp(exponents.x * t), -exp(-exponents.y * t));
}

fn adumbra_moments_of(depth: f32, exponents: vec2f) -> vec4f {
    let w = adumbra_evsm_warp(depth, exponents);
    return vec4f(w.x, w.x * w.x, w.y, w.y * w.y);
}

fn adumbra_moments_visibility(m: vec4f, depth: f32, deviation: f32, params: AdumbraMomentParams) -> f32 {
    let w = adumbra_evsm_warp(depth, params.exponents);
    // The deviation, scaled by the slope of the warp at this depth.
    let stretched = 2.0 * deviation * params.exponents * w;
    let positive = adumbra_moments_chebyshev(m.xy, w.x, stretched.x * stretched.x, params.bleed);
    let negative = adumbra_moments_chebyshev(m.zw, w.y, stretched.y * stretched.y, params.bleed);
    return min(positive, negative);
}
