// Shadow maps: soft shadows of a sun with a size.

@group(2) @binding(1) var map_depth: texture_depth_2d_array;
@group(2) @binding(3) var map_gathering: sampler;

fn map_filter(s: Surface, layer: u32) -> f32 {
    let scale = map_params.layers[layer].scale;
    let cone_texels = map_params.reach.z * scale.y / scale.x;
    let r = map_receiver_in(s, layer);
    return pcss_visibility(map_depth, map_gathering, r, cone_texels, map_params.reach.w, disc_turn(s.pixel));
}
