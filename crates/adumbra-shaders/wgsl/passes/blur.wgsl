// Blur of the shadow factor: a Gaussian in screen space that reads only the factor. Source: ZwqXin, notes on
// soft shadows, 2009. One thread per texel. The line variants are one of two separable passes, along `axis`;
// the square variants do both at once. *_table uses weights computed once on the CPU, *_shader computes each
// weight where it is used, as in the notes. Texels beyond the border repeat the last texel.

fn factor_at(texel: vec2i) -> f32 {
    return factor_within(texel, blur.size);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn blur_line_table(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size)) {
        return;
    }
    let texel = vec2i(id.xy);
    var sum = blur.taps[0].weight * factor_at(texel);
    for (var i = 1; i <= i32(blur.taps_per_side); i++) {
        sum += blur.taps[i].weight * (factor_at(texel - along(i)) + factor_at(texel + along(i)));
    }
    write_factor(id.xy, sum);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn blur_line_shader(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size)) {
        return;
    }
    let texel = vec2i(id.xy);
    let side = i32(blur.taps_per_side);
    var sum = 0.0;
    var weights = 0.0;
    for (var i = -side; i <= side; i++) {
        let weight = adumbra_blur_gauss(f32(i), blur.sigma_texels);
        sum += weight * factor_at(texel + along(i));
        weights += weight;
    }
    write_factor(id.xy, sum / weights);
}

// Returns the weighted sum over a square, and the sum of the weights.
fn square_sum(texel: vec2i, from_table: bool) -> vec2f {
    let side = i32(blur.taps_per_side);
    var sum = vec2f(0.0);
    for (var y = -side; y <= side; y++) {
        for (var x = -side; x <= side; x++) {
            var weight: f32;
            if (from_table) {
                weight = blur.taps[abs(x)].weight * blur.taps[abs(y)].weight;
            } else {
                weight = adumbra_blur_gauss(length(vec2f(f32(x), f32(y))), blur.sigma_texels);
            }
            sum += weight * vec2f(factor_at(texel + vec2i(x, y)), 1.0);
        }
    }
    return sum;
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn blur_square_table(@builtin(global_invocation_id) id: vec3u) {
    if (all(id.xy < blur.size)) {
        // These weights add up to 1.
        write_factor(id.xy, square_sum(vec2i(id.xy), true).x);
    }
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn blur_square_shader(@builtin(global_invocation_id) id: vec3u) {
    if (all(id.xy < blur.size)) {
        let sum = square_sum(vec2i(id.xy), false);
        write_factor(id.xy, sum.x / sum.y);
    }
}

// Morphological dilation of the shadow by `dilation_texels`, one axis per pass: the darkest texel of the
// line.
@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn dilate_line(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size)) {
        return;
    }
    let texel = vec2i(id.xy);
    var darkest = factor_at(texel);
    for (var i = 1; i <= i32(blur.dilation_texels); i++) {
        darkest = min(darkest, min(factor_at(texel - along(i)), factor_at(texel + along(i))));
    }
    write_factor(id.xy, darkest);
}
