// Visibility from a shadow map of one or more layers: the layer of the point's view depth, blended into the next at its end, and into
// the open light where shadows end. A filter is a file that defines
//     fn map_filter(s: Surface, layer: u32) -> f32

@group(2) @binding(0) var<uniform> map_params: MapParams;

fn map_layer_of(view_depth: f32) -> u32 {
    let last = map_params.counts.x - 1u;
    var layer = 0u;
    while (layer < last && view_depth >= map_params.layers[layer].scale.z) {
        layer++;
    }
    return layer;
}

fn map_receiver_in(s: Surface, layer: u32) -> MapReceiver {
    let least_bias = map_params.pixel.w;
    return map_receiver(map_params.layers[layer], layer, map_params.counts.y, map_params.bias, least_bias, s);
}

// Beside the layer nothing is known, and what is there is lit: movers may stand beside what stands still.
fn map_lit(s: Surface, layer: u32) -> f32 {
    let p_texels = map_receiver_in(s, layer).p_texels;
    if (any(p_texels < vec2f(0.0)) || any(p_texels > vec2f(f32(map_params.counts.y)))) {
        return 1.0;
    }
    return map_filter(s, layer);
}

fn map_visibility(s: Surface) -> f32 {
    let reach = map_params.reach;
    if (s.view_depth >= reach.y) {
        return 1.0;
    }
    let layer = map_layer_of(s.view_depth);
    let scale = map_params.layers[layer].scale;
    var lit = map_lit(s, layer);
    let next = map_band(scale.w, scale.z, s.view_depth);
    if (next > 0.0 && layer + 1u < map_params.counts.x) {
        lit = mix(lit, map_lit(s, layer + 1u), next);
    }
    return mix(lit, 1.0, map_band(reach.x, reach.y, s.view_depth));
}
