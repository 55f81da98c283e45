// Shadow maps: soft shadows of an area sun.

@group(2) @binding(1) var map_depth: texture_depth_2d_array;
@group(2) @binding(3) var map_gathering: sampler;

fn map_filter(s: AdumbraSurface, layer: u32) -> f32 {
    let depth_world = map_params.layers[layer].depth_world;
    let cone_texels = map_params.sun_tangent * depth_world / map_params.layers[layer].texel_world;
    let r = map_receiver_in(s, layer);
    return adumbra_pcss_visibility(map_depth, map_gathering, r, cone_texels, map_params.max_radius_texels, adumbra_disc_turn(s.pixel));
}
