// Shadow maps: the mean of comparisons over a square.

@group(2) @binding(1) var map_depth: texture_depth_2d_array;
@group(2) @binding(3) var map_gathering: sampler;

fn map_filter(s: AdumbraSurface, layer: u32) -> f32 {
    return adumbra_pcf_box(map_depth, map_gathering, map_receiver_in(s, layer), map_params.filter_width);
}
