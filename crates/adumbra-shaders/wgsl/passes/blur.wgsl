// The notes' blur of the shadow factor: a Gaussian over the picture that sees nothing but the factor. One thread a texel. A line is one
// of two passes (counts.z says along which axis), the square does both at once. *_table takes weights computed once on the CPU,
// *_shader computes each where it is used, as the notes have it. Beyond the picture's border its last texel goes on.

@group(0) @binding(0) var<uniform> blur: BlurParams;
@group(0) @binding(1) var factor_in: texture_2d<f32>;
@group(0) @binding(2) var factor_out: texture_storage_2d<r32float, write>;

fn factor_at(texel: vec2i) -> f32 {
    return textureLoad(factor_in, clamp(texel, vec2i(0), vec2i(blur.size.xy) - 1), 0).x;
}

fn along(distance: i32) -> vec2i {
    return select(vec2i(distance, 0), vec2i(0, distance), blur.counts.z == 1u);
}

fn write_factor(texel: vec2u, factor: f32) {
    textureStore(factor_out, texel, vec4f(factor, 0.0, 0.0, 0.0));
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn blur_line_table(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size.xy)) {
        return;
    }
    let texel = vec2i(id.xy);
    var sum = blur.taps[0].x * factor_at(texel);
    for (var i = 1; i <= i32(blur.counts.x); i++) {
        sum += blur.taps[i].x * (factor_at(texel - along(i)) + factor_at(texel + along(i)));
    }
    write_factor(id.xy, sum);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn blur_line_shader(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size.xy)) {
        return;
    }
    let texel = vec2i(id.xy);
    let side = i32(blur.counts.x);
    var sum = 0.0;
    var weights = 0.0;
    for (var i = -side; i <= side; i++) {
        let weight = blur_gauss(f32(i), blur.shape.x);
        sum += weight * factor_at(texel + along(i));
        weights += weight;
    }
    write_factor(id.xy, sum / weights);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn blur_square_table(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size.xy)) {
        return;
    }
    let texel = vec2i(id.xy);
    let side = i32(blur.counts.x);
    var sum = 0.0;
    for (var y = -side; y <= side; y++) {
        for (var x = -side; x <= side; x++) {
            sum += blur.taps[abs(x)].x * blur.taps[abs(y)].x * factor_at(texel + vec2i(x, y));
        }
    }
    write_factor(id.xy, sum);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn blur_square_shader(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size.xy)) {
        return;
    }
    let texel = vec2i(id.xy);
    let side = i32(blur.counts.x);
    var sum = 0.0;
    var weights = 0.0;
    for (var y = -side; y <= side; y++) {
        for (var x = -side; x <= side; x++) {
            let weight = blur_gauss(length(vec2f(f32(x), f32(y))), blur.shape.x);
            sum += weight * factor_at(texel + vec2i(x, y));
            weights += weight;
        }
    }
    write_factor(id.xy, sum / weights);
}

// Morphological dilation of the shade by counts.w texels, one axis a pass: the darkest of the line.
@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn dilate_line(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size.xy)) {
        return;
    }
    let texel = vec2i(id.xy);
    var darkest = factor_at(texel);
    for (var i = 1; i <= i32(blur.counts.w); i++) {
        darkest = min(darkest, min(factor_at(texel - along(i)), factor_at(texel + along(i))));
    }
    write_factor(id.xy, darkest);
}
