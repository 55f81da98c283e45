// Moments of one layer's depth, blurred along rows by a Gaussian; one thread a texel. The border's texels are repeated beyond it, and
// other layers are never read.

@group(0) @binding(0) var<uniform> blur: MomentBlurParams;
@group(0) @binding(1) var map_depth: texture_depth_2d_array;
@group(0) @binding(2) var moments_out: MomentsOut;

fn moments_at(x: i32, y: i32) -> vec4f {
    let column = clamp(x, 0, i32(blur.counts.y) - 1);
    return moments_of(textureLoad(map_depth, vec2i(column, y), i32(blur.counts.x), 0), blur.exponents.xy);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn moments_rows(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.counts.yy)) {
        return;
    }
    let texel = vec2i(id.xy);
    var sum = blur.weights[0].x * moments_at(texel.x, texel.y);
    for (var i = 1; i <= i32(blur.counts.z); i++) {
        let weight = blur.weights[i / 4][i % 4];
        sum += weight * (moments_at(texel.x - i, texel.y) + moments_at(texel.x + i, texel.y));
    }
    textureStore(moments_out, texel, sum);
}
