// Shadow maps: compares the texel that contains the point.
// Source: Williams, Casting Curved Shadows on Curved Surfaces, 1978.

@group(2) @binding(1) var map_depth: texture_depth_2d_array;

fn map_filter(s: AdumbraSurface, layer: u32) -> f32 {
    return adumbra_pcf_nearest(map_depth, map_receiver_in(s, layer));
}
