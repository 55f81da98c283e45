// The layer of a shadow map that contains a point, from 0; -1 beyond the end of the shadows.

@group(2) @binding(0) var<uniform> map_params: AdumbraMapParams;

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    if (s.view_depth >= map_params.fade_end_view_depth) {
        return -1.0;
    }
    let last = map_params.layer_count - 1u;
    var layer = 0u;
    while (layer < last && s.view_depth >= map_params.layers[layer].end_view_depth) {
        layer++;
    }
    return f32(layer);
}
