// Moment-based shadow maps, interpolated in the shader from the first mip level, for devices that cannot
// filter 32-bit floats.

@group(2) @binding(1) var map_moments: texture_2d_array<f32>;

fn map_filter(s: AdumbraSurface, layer: u32) -> f32 {
    let r = map_receiver_in(s, layer);
    let m = adumbra_moments_loaded(map_moments, r);
    let texel_world = map_params.layers[layer].texel_world;
    let deviation = map_params.moments.min_deviation_texels * texel_world / map_params.layers[layer].depth_world;
    // A receiver in front of or behind the layer is clamped to its border, because warps of depths outside it
    // overflow.
    return adumbra_moments_visibility(m, clamp(r.depth, 0.0, 1.0), deviation, map_params.moments);
}
