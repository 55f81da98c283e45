// The level at which a look-up in a hybrid map ends: 0 is the finest, -1 is outside the map.

@group(2) @binding(0) var<uniform> hybrid: AdumbraHybridParams;

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    let r = adumbra_map_receiver(hybrid.layer, 0u, hybrid.start_texels, hybrid.bias, hybrid.min_bias_depth, s);
    if (any(r.p_texels < vec2f(0.0)) || any(r.p_texels > vec2f(f32(hybrid.start_texels)))) {
        return -1.0;
    }
    let shape = adumbra_hybrid_shape(hybrid);
    return f32(adumbra_hybrid_texel(shape, adumbra_hybrid_receiver_texel(shape, r)).level);
}
