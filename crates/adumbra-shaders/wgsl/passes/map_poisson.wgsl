// Shadow maps: the mean of 16 comparisons in a disc, turned from pixel to pixel.

@group(2) @binding(1) var map_depth: texture_depth_2d_array;
@group(2) @binding(3) var map_gathering: sampler;

fn map_filter(s: Surface, layer: u32) -> f32 {
    let r = map_receiver_in(s, layer);
    return pcf_disc(map_depth, map_gathering, r, map_params.reach.w, map_params.counts.w, disc_turn(s.pixel));
}
