// The level that a look-up in a hybrid map ends at: 0 the finest; -1 beside the map.

@group(2) @binding(0) var<uniform> hybrid: HybridParams;

fn shadow_factor(s: Surface) -> f32 {
    let r = map_receiver(hybrid.layer, 0u, hybrid.counts.x, hybrid.bias, hybrid.least_bias.x, s);
    if (any(r.p_texels < vec2f(0.0)) || any(r.p_texels > vec2f(f32(hybrid.counts.x)))) {
        return -1.0;
    }
    let shape = hybrid_shape(hybrid);
    return f32(hybrid_texel(shape, hybrid_receiver_texel(shape, r)).level);
}
