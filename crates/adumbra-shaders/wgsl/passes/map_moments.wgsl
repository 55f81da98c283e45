// Shadow maps of moments, through a filtering sampler and its mip levels. Needs the filtering of 32-bit floats.

@group(2) @binding(1) var map_moments: texture_2d_array<f32>;
@group(2) @binding(2) var map_filtering: sampler;

fn map_filter(s: Surface, layer: u32) -> f32 {
    let r = map_receiver_in(s, layer);
    let level = moments_level(map_params.pixel, map_params.layers[layer], s.view_depth);
    let uv = r.p_texels / f32(map_params.counts.y);
    let m = textureSampleLevel(map_moments, map_filtering, uv, r.layer, level);
    let scale = map_params.layers[layer].scale;
    // A receiver before or behind the layer is at its border: warps of depths beyond overflow.
    return moments_visibility(m, clamp(r.depth, 0.0, 1.0), map_params.moments.x * scale.x / scale.y, map_params.moments);
}
