// Shadow maps of moments, blended here from the first mip level: for devices that cannot filter 32-bit floats.

@group(2) @binding(1) var map_moments: texture_2d_array<f32>;

fn map_filter(s: Surface, layer: u32) -> f32 {
    let r = map_receiver_in(s, layer);
    let scale = map_params.layers[layer].scale;
    let m = moments_loaded(map_moments, r);
    // A receiver before or behind the layer is at its border: warps of depths beyond overflow.
    return moments_visibility(m, clamp(r.depth, 0.0, 1.0), map_params.moments.x * scale.x / scale.y, map_params.moments);
}
