// Shadow maps: the sampler's own 2 × 2 comparisons.

@group(2) @binding(1) var map_depth: texture_depth_2d_array;
@group(2) @binding(2) var map_comparing: sampler_comparison;

fn map_filter(s: AdumbraSurface, layer: u32) -> f32 {
    return adumbra_pcf_hardware(map_depth, map_comparing, map_receiver_in(s, layer));
}
