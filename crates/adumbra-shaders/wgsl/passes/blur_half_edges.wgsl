// Scales to half of the picture's width and height and back within surfaces. Texel q has the surface of pixel
// 2q, and only values on that surface are mixed. One thread per texel written.
// `size` is that of the half picture, `frame_size` that of the full one.

// The factor before the blur, at full size, for pixels whose surface none of the nearby texels has.
@group(0) @binding(6) var factor_whole: texture_2d<f32>;

fn share(pixel: vec2u, other: vec2u) -> f32 {
    let depth = textureLoad(gbuffer_depth, pixel, 0);
    let other_depth = textureLoad(gbuffer_depth, other, 0);
    if (depth == 0.0 || other_depth == 0.0) {
        return 0.0;
    }
    let a = surface_at(pixel, depth);
    let b = surface_at(other, other_depth);
    // Texels are twice as far apart as pixels.
    return adumbra_blur_same_surface(a, b, 2.0 * blur.tolerance_pixels * adumbra_blur_pixel_world(frame, a.view_depth));
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn half_down_edges(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size)) {
        return;
    }
    let first = 2u * id.xy;
    var sum = textureLoad(factor_in, first, 0).x;
    var weights = 1.0;
    for (var i = 1u; i < 4u; i++) {
        let other = first + vec2u(i & 1u, i >> 1u);
        if (all(other < blur.frame_size)) {
            let weight = share(first, other);
            sum += weight * textureLoad(factor_in, other, 0).x;
            weights += weight;
        }
    }
    write_factor(id.xy, sum / weights);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn half_up_edges(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.frame_size)) {
        return;
    }
    let at = (vec2f(id.xy) - 0.5) * 0.5;
    let first = vec2i(floor(at));
    let part = at - floor(at);
    var sum = 0.0;
    var weights = 0.0;
    for (var i = 0; i < 4; i++) {
        let step = vec2i(i & 1, i >> 1u);
        let texel = clamp(first + step, vec2i(0), vec2i(blur.size) - 1);
        let linear = select(1.0 - part, part, step == vec2i(1));
        let weight = linear.x * linear.y * share(id.xy, 2u * vec2u(texel));
        sum += weight * textureLoad(factor_in, texel, 0).x;
        weights += weight;
    }
    var factor = textureLoad(factor_whole, id.xy, 0).x;
    if (weights > 0.01) {
        factor = sum / weights;
    }
    write_factor(id.xy, factor);
}
