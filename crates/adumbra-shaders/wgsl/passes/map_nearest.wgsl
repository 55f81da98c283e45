// Shadow maps: the texel that a point lies in, compared.
// Source: Williams, Casting Curved Shadows on Curved Surfaces, 1978.

@group(2) @binding(1) var map_depth: texture_depth_2d_array;

fn map_filter(s: Surface, layer: u32) -> f32 {
    return pcf_nearest(map_depth, map_receiver_in(s, layer));
}
