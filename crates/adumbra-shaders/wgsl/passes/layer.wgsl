// What a viewer shows of a frame: one of its layers, display-encoded, the mean of samples x samples pixels each; one thread a pixel shown.
// The arithmetic is that of the program's pictures of layers on the CPU, which tests hold it against.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> layer: LayerParams;
@group(0) @binding(2) var layer_depth: texture_depth_2d;
@group(0) @binding(3) var layer_normal: texture_2d<f32>;
@group(0) @binding(4) var layer_picture: texture_2d<f32>;
// Visibilities, or what a tint stands for; of the frame's size, or a single texel for all.
@group(0) @binding(5) var layer_values: texture_2d<f32>;
// Bits of the largest stored depth, the nearest surface's.
@group(0) @binding(6) var<storage, read_write> layer_nearest: atomic<u32>;
@group(0) @binding(7) var layer_out: texture_storage_2d<rgba8unorm, write>;

var<workgroup> group_nearest: atomic<u32>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn layer_find_nearest(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    if (all(id.xy < frame.size.xy)) {
        // Depths are at least 0, where bits order as the numbers do.
        atomicMax(&group_nearest, bitcast<u32>(textureLoad(layer_depth, id.xy, 0)));
    }
    workgroupBarrier();
    if (local == 0u) {
        atomicMax(&layer_nearest, atomicLoad(&group_nearest));
    }
}

fn layer_value(pixel: vec2u) -> f32 {
    return textureLoad(layer_values, min(pixel, textureDimensions(layer_values) - 1u), 0).x;
}

// Of one pixel of the frame, before encoding.
fn layer_pixel(pixel: vec2u) -> vec3f {
    let kind = layer.shape.w;
    if (kind == LAYER_VALUE) {
        return vec3f(layer_value(pixel));
    }
    if (kind == LAYER_DEPTH || kind == LAYER_NORMAL) {
        let depth = textureLoad(layer_depth, pixel, 0);
        if (depth == 0.0) {
            return vec3f(0.0);
        }
        if (kind == LAYER_NORMAL) {
            return 0.5 + 0.5 * textureLoad(layer_normal, pixel, 0).xyz;
        }
        let nearest = frame_view_depth(frame, bitcast<f32>(atomicLoad(&layer_nearest)));
        return vec3f(sqrt(nearest / frame_view_depth(frame, depth)));
    }
    let color = srgb_decoded(textureLoad(layer_picture, pixel, 0).rgb);
    let index = layer_value(pixel);
    if (kind == LAYER_COLOR || index < 0.0) {
        return color;
    }
    let grey = (color.r + color.g + color.b) / 3.0;
    return layer.palette[min(u32(index), layer.counts.x - 1u)].rgb * (0.25 + 1.5 * grey);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn layer_show(@builtin(global_invocation_id) id: vec3u) {
    let size = layer.shape.xy;
    if (any(id.xy >= size)) {
        return;
    }
    let samples = layer.shape.z;
    var sum = vec3f(0.0);
    for (var s = 0u; s < samples * samples; s++) {
        sum += layer_pixel(id.xy * samples + vec2u(s % samples, s / samples));
    }
    let mean = sum / f32(samples * samples);
    let kind = layer.shape.w;
    let is_color = kind == LAYER_COLOR || kind == LAYER_TINT;
    let shown = select(clamp(mean, vec3f(0.0), vec3f(1.0)), srgb_encoded(mean), is_color);
    textureStore(layer_out, id.xy, vec4f(shown, 1.0));
}
