// Code shared by all depth moments. Each kind (vsm.wgsl, evsm.wgsl or msm.wgsl) defines
//     alias AdumbraMomentsOut                                          the storage texture that holds them
//     fn adumbra_moments_of(depth: f32, exponents: vec2f) -> vec4f      of one depth
//     fn adumbra_moments_visibility(m: vec4f, depth: f32, deviation: f32, params: AdumbraMomentParams) -> f32
// where `deviation` is the smallest standard deviation in depth units.

// Returns Chebyshev's upper bound on the fraction of depths at or behind t, given their mean and mean square.
// The tail of the bound below `bleed` is cut off, and the rest is rescaled. Source: Donnelly, Lauritzen,
// Variance Shadow Maps, 2006; the cut: Lauritzen, Summed-Area Variance Shadow Maps, 2007.
fn adumbra_moments_chebyshev(m: vec2f, t: f32, min_variance: f32, bleed: f32) -> f32 {
    if (t <= m.x) {
        return 1.0;
    }
    // The lower limit prevents 0 / 0, whether from rounding or from a minimum deviation of 0.
    let variance = max(m.y - m.x * m.x, max(min_variance, 1e-12));
    let behind = t - m.x;
    return adumbra_moments_cut(variance / (variance + behind * behind), bleed);
}

fn adumbra_moments_cut(bound: f32, bleed: f32) -> f32 {
    return clamp((bound - bleed) / (1.0 - bleed), 0.0, 1.0);
}

// Reads the first mip level with bilinear interpolation.
fn adumbra_moments_loaded(moments: texture_2d_array<f32>, r: AdumbraMapReceiver) -> vec4f {
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

// Returns the mip level, out of `levels`, whose texels are as large as a pixel.
fn adumbra_moments_level(layer: AdumbraMapLayer, pixel_world: f32, levels: f32) -> f32 {
    return clamp(log2(max(pixel_world / layer.texel_world, 1.0)), 0.0, levels - 1.0);
}
