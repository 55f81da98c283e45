// Scales to half of the picture's width and height and back, without regard to surfaces: down by means of
// four pixels, up by bilinear interpolation. One thread per texel written.
// `size` is that of the half picture, `frame_size` that of the full one.

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn half_down(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size)) {
        return;
    }
    let p = 2 * vec2i(id.xy);
    let size = blur.frame_size;
    let upper = factor_within(p, size) + factor_within(p + vec2i(1, 0), size);
    let lower = factor_within(p + vec2i(0, 1), size) + factor_within(p + vec2i(1, 1), size);
    write_factor(id.xy, 0.25 * (upper + lower));
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn half_up(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.frame_size)) {
        return;
    }
    let at = (vec2f(id.xy) - 0.5) * 0.5;
    let first = vec2i(floor(at));
    let part = at - floor(at);
    let size = blur.size;
    let upper = mix(factor_within(first, size), factor_within(first + vec2i(1, 0), size), part.x);
    let lower = mix(factor_within(first + vec2i(0, 1), size), factor_within(first + vec2i(1, 1), size), part.x);
    write_factor(id.xy, mix(upper, lower, part.y));
}
