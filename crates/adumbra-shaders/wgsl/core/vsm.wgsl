// Variance shadow maps: mean and mean square of depth. Depth is measured from the middle of the layer, where
// 32-bit floats are most precise. Source: Donnelly, Lauritzen, Variance Shadow Maps, 2006.

alias AdumbraMomentsOut = texture_storage_2d<rg32float, write>;

fn adumbra_moments_of(depth: f32, exponents: vec2f) -> vec4f {
    let t = depth - 0.5;
    return vec4f(t, t * t, 0.0, 0.0);
}

fn adumbra_moments_visibility(m: vec4f, depth: f32, deviation: f32, params: AdumbraMomentParams) -> f32 {
    return adumbra_moments_chebyshev(m.xy, depth - 0.5, deviation * deviation, params.bleed);
}
