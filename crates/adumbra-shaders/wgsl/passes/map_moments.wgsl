// Moment-based shadow maps, read with a filtering sampler and mip levels. Requires filtering of 32-bit
// floats.

@group(2) @binding(1) var map_moments: texture_2d_array<f32>;
@group(2) @binding(2) var map_filtering: sampler;

fn map_filter(s: AdumbraSurface, layer: u32) -> f32 {
    let r = map_receiver_in(s, layer);
    let pixel_world = map_params.pixel_world + map_params.pixel_world_per_depth * max(s.view_depth, 0.0);
    let level = adumbra_moments_level(map_params.layers[layer], pixel_world, map_params.mip_levels);
    let uv = r.p_texels / f32(map_params.side_texels);
    let m = textureSampleLevel(map_moments, map_filtering, uv, r.layer, level);
    let texel_world = map_params.layers[layer].texel_world;
    let deviation = map_params.moments.min_deviation_texels * texel_world / map_params.layers[layer].depth_world;
    // A receiver in front of or behind the layer is clamped to its border, because warps of depths outside it
    // overflow.
    return adumbra_moments_visibility(m, clamp(r.depth, 0.0, 1.0), deviation, map_params.moments);
}
