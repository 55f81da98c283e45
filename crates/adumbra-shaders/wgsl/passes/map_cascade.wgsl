// The layer of a shadow map that a point falls in, from 0; -1 where shadows have ended.

@group(2) @binding(0) var<uniform> map_params: MapParams;

fn shadow_factor(s: Surface) -> f32 {
    if (s.view_depth >= map_params.reach.y) {
        return -1.0;
    }
    let last = map_params.counts.x - 1u;
    var layer = 0u;
    while (layer < last && s.view_depth >= map_params.layers[layer].scale.z) {
        layer++;
    }
    return f32(layer);
}
