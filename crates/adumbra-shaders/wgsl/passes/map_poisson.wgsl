// Shadow maps: the mean of 16 bilinear taps in a disc (`tap_count`), rotated per pixel.

@group(2) @binding(1) var map_depth: texture_depth_2d_array;
@group(2) @binding(3) var map_gathering: sampler;

fn map_filter(s: AdumbraSurface, layer: u32) -> f32 {
    let r = map_receiver_in(s, layer);
    return adumbra_pcf_disc(map_depth, map_gathering, r, map_params.max_radius_texels, map_params.tap_count, adumbra_disc_turn(s.pixel));
}
