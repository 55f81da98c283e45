// The technique `hrsm`: a hybrid-resolution shadow map. A filter is a file that defines
//     fn hybrid_filter(r: AdumbraMapReceiver) -> f32

@group(2) @binding(0) var<uniform> hybrid: AdumbraHybridParams;

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    let r = adumbra_map_receiver(hybrid.layer, 0u, hybrid.start_texels, hybrid.bias, hybrid.min_bias_depth, s);
    if (any(r.p_texels < vec2f(0.0)) || any(r.p_texels > vec2f(f32(hybrid.start_texels)))) {
        return 1.0;
    }
    return hybrid_filter(r);
}
