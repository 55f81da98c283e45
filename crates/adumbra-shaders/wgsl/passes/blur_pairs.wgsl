// One axis of the blur with two neighbours per sample: each sample is taken between their centres, where
// linear filtering mixes them by their weights. One thread per texel. The result equals that of
// blur_line_table, with about half the samples.

@group(0) @binding(3) var factor_sampler: sampler;

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn blur_line_pairs(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size)) {
        return;
    }
    let size = vec2f(blur.size);
    let uv = (vec2f(id.xy) + 0.5) / size;
    let axis = vec2f(along(1)) / size;
    var sum = blur.taps[0].weight * textureSampleLevel(factor_in, factor_sampler, uv, 0.0).x;
    for (var i = 0u; i < blur.pair_count; i++) {
        let offset = blur.taps[i].pair_offset_texels * axis;
        let before = textureSampleLevel(factor_in, factor_sampler, uv - offset, 0.0).x;
        let after = textureSampleLevel(factor_in, factor_sampler, uv + offset, 0.0).x;
        sum += blur.taps[i].pair_weight * (before + after);
    }
    write_factor(id.xy, sum);
}
