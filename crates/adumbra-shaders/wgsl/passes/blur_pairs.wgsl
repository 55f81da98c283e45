// A line of the blur with two neighbours a sample: between their centres, where linear filtering mixes them by their weights. One thread
// a texel; the same answer as blur_line_table with about half the samples. taps[i].yz: offset and weight of pair i.

@group(0) @binding(0) var<uniform> blur: BlurParams;
@group(0) @binding(1) var factor_in: texture_2d<f32>;
@group(0) @binding(2) var factor_out: texture_storage_2d<r32float, write>;
@group(0) @binding(3) var factor_sampler: sampler;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn blur_line_pairs(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size.xy)) {
        return;
    }
    let size = vec2f(blur.size.xy);
    let uv = (vec2f(id.xy) + 0.5) / size;
    let axis = select(vec2f(1.0, 0.0), vec2f(0.0, 1.0), blur.counts.z == 1u) / size;
    var sum = blur.taps[0].x * textureSampleLevel(factor_in, factor_sampler, uv, 0.0).x;
    for (var i = 0u; i < blur.pairs.x; i++) {
        let offset = blur.taps[i].y * axis;
        let before = textureSampleLevel(factor_in, factor_sampler, uv - offset, 0.0).x;
        let after = textureSampleLevel(factor_in, factor_sampler, uv + offset, 0.0).x;
        sum += blur.taps[i].z * (before + after);
    }
    textureStore(factor_out, id.xy, vec4f(sum, 0.0, 0.0, 0.0));
}
