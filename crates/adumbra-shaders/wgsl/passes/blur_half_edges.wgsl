// To half of the picture's width and height and back within one surface: texel q has the surface of pixel 2q, and mixes only what lies on
// it. One thread a texel written. size.xy: the half picture; size.zw: the whole one.

@group(0) @binding(0) var<uniform> blur: BlurParams;
@group(0) @binding(1) var factor_in: texture_2d<f32>;
@group(0) @binding(2) var factor_out: texture_storage_2d<r32float, write>;
@group(0) @binding(3) var<uniform> frame: Frame;
@group(0) @binding(4) var gbuffer_depth: texture_depth_2d;
@group(0) @binding(5) var gbuffer_normal: texture_2d<f32>;
// The factor before the blur, at full size: for pixels that no texel near them speaks for.
@group(0) @binding(6) var factor_whole: texture_2d<f32>;

fn share(pixel: vec2u, other: vec2u) -> f32 {
    let depth = textureLoad(gbuffer_depth, pixel, 0);
    let other_depth = textureLoad(gbuffer_depth, other, 0);
    if (depth == 0.0 || other_depth == 0.0) {
        return 0.0;
    }
    let a = frame_surface(frame, pixel, depth, textureLoad(gbuffer_normal, pixel, 0).xyz);
    let b = frame_surface(frame, other, other_depth, textureLoad(gbuffer_normal, other, 0).xyz);
    // Texels are twice as far apart as pixels.
    return blur_same_surface(a, b, 2.0 * blur.shape.y * blur_pixel_world(frame, a.view_depth));
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn half_down_edges(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size.xy)) {
        return;
    }
    let first = 2u * id.xy;
    var sum = textureLoad(factor_in, first, 0).x;
    var weights = 1.0;
    for (var i = 1u; i < 4u; i++) {
        let other = first + vec2u(i & 1u, i >> 1u);
        if (all(other < blur.size.zw)) {
            let weight = share(first, other);
            sum += weight * textureLoad(factor_in, other, 0).x;
            weights += weight;
        }
    }
    textureStore(factor_out, id.xy, vec4f(sum / weights, 0.0, 0.0, 0.0));
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn half_up_edges(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size.zw)) {
        return;
    }
    let at = (vec2f(id.xy) - 0.5) * 0.5;
    let first = vec2i(floor(at));
    let part = at - floor(at);
    var sum = 0.0;
    var weights = 0.0;
    for (var i = 0; i < 4; i++) {
        let step = vec2i(i & 1, i >> 1u);
        let texel = clamp(first + step, vec2i(0), vec2i(blur.size.xy) - 1);
        let linear = select(1.0 - part, part, step == vec2i(1));
        let weight = linear.x * linear.y * share(id.xy, 2u * vec2u(texel));
        sum += weight * textureLoad(factor_in, texel, 0).x;
        weights += weight;
    }
    var factor = textureLoad(factor_whole, id.xy, 0).x;
    if (weights > 0.01) {
        factor = sum / weights;
    }
    textureStore(factor_out, id.xy, vec4f(factor, 0.0, 0.0, 0.0));
}
