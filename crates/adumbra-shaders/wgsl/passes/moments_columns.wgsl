// Moments of one layer, blurred along columns by a Gaussian; one thread a texel.

@group(0) @binding(0) var<uniform> blur: MomentBlurParams;
@group(0) @binding(1) var moments_in: texture_2d<f32>;
@group(0) @binding(2) var moments_out: MomentsOut;

fn moments_at(x: i32, y: i32) -> vec4f {
    return textureLoad(moments_in, vec2i(x, clamp(y, 0, i32(blur.counts.y) - 1)), 0);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn moments_columns(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.counts.yy)) {
        return;
    }
    let texel = vec2i(id.xy);
    var sum = blur.weights[0].x * moments_at(texel.x, texel.y);
    for (var i = 1; i <= i32(blur.counts.z); i++) {
        let weight = blur.weights[i / 4][i % 4];
        sum += weight * (moments_at(texel.x, texel.y - i) + moments_at(texel.x, texel.y + i));
    }
    textureStore(moments_out, texel, sum);
}
