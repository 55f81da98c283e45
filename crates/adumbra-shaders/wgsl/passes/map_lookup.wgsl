// Visibility from a shadow map with one or more layers. The layer is selected by the point's view depth,
// blended into the next one at its end, and faded to fully lit where shadows end. A filter is a file that
// defines
//     fn map_filter(s: AdumbraSurface, layer: u32) -> f32

@group(2) @binding(0) var<uniform> map_params: AdumbraMapParams;

fn map_layer_of(view_depth: f32) -> u32 {
    let last = map_params.layer_count - 1u;
    var layer = 0u;
    while (layer < last && view_depth >= map_params.layers[layer].end_view_depth) {
        layer++;
    }
    return layer;
}

fn map_receiver_in(s: AdumbraSurface, layer: u32) -> AdumbraMapReceiver {
    let min_bias = map_params.min_bias_depth;
    return adumbra_map_receiver(map_params.layers[layer], layer, map_params.side_texels, map_params.bias, min_bias, s);
}

// Everything outside the layer is unknown and counts as lit: movers may be beside static casters.
fn map_lit(s: AdumbraSurface, layer: u32) -> f32 {
    let p_texels = map_receiver_in(s, layer).p_texels;
    if (any(p_texels < vec2f(0.0)) || any(p_texels > vec2f(f32(map_params.side_texels)))) {
        return 1.0;
    }
    return map_filter(s, layer);
}

fn map_visibility(s: AdumbraSurface) -> f32 {
    if (s.view_depth >= map_params.fade_end_view_depth) {
        return 1.0;
    }
    let layer = map_layer_of(s.view_depth);
    var lit = map_lit(s, layer);
    let next = adumbra_map_band(map_params.layers[layer].blend_view_depth, map_params.layers[layer].end_view_depth, s.view_depth);
    if (next > 0.0 && layer + 1u < map_params.layer_count) {
        lit = mix(lit, map_lit(s, layer + 1u), next);
    }
    return mix(lit, 1.0, adumbra_map_band(map_params.fade_view_depth, map_params.fade_end_view_depth, s.view_depth));
}
