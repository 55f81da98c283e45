// To half of the picture's width and height and back, blind to what is seen: means of four pixels, and linear between texels. One thread a
// texel written. size.xy: the half picture; size.zw: the whole one.

@group(0) @binding(0) var<uniform> blur: BlurParams;
@group(0) @binding(1) var factor_in: texture_2d<f32>;
@group(0) @binding(2) var factor_out: texture_storage_2d<r32float, write>;

fn factor_at(texel: vec2i, size: vec2u) -> f32 {
    return textureLoad(factor_in, clamp(texel, vec2i(0), vec2i(size) - 1), 0).x;
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn half_down(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size.xy)) {
        return;
    }
    let p = 2 * vec2i(id.xy);
    let size = blur.size.zw;
    let upper = factor_at(p, size) + factor_at(p + vec2i(1, 0), size);
    let lower = factor_at(p + vec2i(0, 1), size) + factor_at(p + vec2i(1, 1), size);
    textureStore(factor_out, id.xy, vec4f(0.25 * (upper + lower), 0.0, 0.0, 0.0));
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn half_up(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size.zw)) {
        return;
    }
    let at = (vec2f(id.xy) - 0.5) * 0.5;
    let first = vec2i(floor(at));
    let part = at - floor(at);
    let size = blur.size.xy;
    let upper = mix(factor_at(first, size), factor_at(first + vec2i(1, 0), size), part.x);
    let lower = mix(factor_at(first + vec2i(0, 1), size), factor_at(first + vec2i(1, 1), size), part.x);
    textureStore(factor_out, id.xy, vec4f(mix(upper, lower, part.y), 0.0, 0.0, 0.0));
}
