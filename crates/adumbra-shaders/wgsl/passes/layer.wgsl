// Displays a frame in a viewer: one of its layers, display-encoded, each displayed pixel being the mean of
// samples x samples pixels. One thread per displayed pixel. The arithmetic is that of the program's CPU
// pictures of layers, against which tests check it.

@group(0) @binding(0) var<uniform> frame: AdumbraFrame;
@group(0) @binding(1) var<uniform> layer: AdumbraLayerParams;
@group(0) @binding(2) var layer_depth: texture_depth_2d;
@group(0) @binding(3) var layer_normal: texture_2d<f32>;
@group(0) @binding(4) var layer_picture: texture_2d<f32>;
// Visibilities or tint indices; has the frame's size, or is a single texel for all pixels.
@group(0) @binding(5) var layer_values: texture_2d<f32>;
// Bits of the largest stored depth, that of the nearest surface.
@group(0) @binding(6) var<storage, read_write> layer_nearest: atomic<u32>;
@group(0) @binding(7) var layer_out: texture_storage_2d<rgba8unorm, write>;

var<workgroup> group_nearest: atomic<u32>;

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn layer_find_nearest(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    if (all(id.xy < frame.size)) {
        // Depths are at least 0, so their bits order like the numbers.
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

// Returns the value of one pixel of the frame, before encoding.
fn layer_pixel(pixel: vec2u) -> vec3f {
    let kind = layer.kind;
    if (kind == ADUMBRA_LAYER_VALUE) {
        return vec3f(layer_value(pixel));
    }
    if (kind == ADUMBRA_LAYER_DEPTH || kind == ADUMBRA_LAYER_NORMAL) {
        let depth = textureLoad(layer_depth, pixel, 0);
        if (depth == 0.0) {
            return vec3f(0.0);
        }
        if (kind == ADUMBRA_LAYER_NORMAL) {
            return 0.5 + 0.5 * textureLoad(layer_normal, pixel, 0).xyz;
        }
        let nearest = adumbra_stored_view_depth(frame.depth_to_z, bitcast<f32>(atomicLoad(&layer_nearest)));
        return vec3f(sqrt(nearest / adumbra_stored_view_depth(frame.depth_to_z, depth)));
    }
    let color = adumbra_srgb_decoded(textureLoad(layer_picture, pixel, 0).rgb);
    let index = layer_value(pixel);
    if (kind == ADUMBRA_LAYER_COLOR || index < 0.0) {
        return color;
    }
    let grey = (color.r + color.g + color.b) / 3.0;
    return layer.palette[min(u32(index), layer.tint_count - 1u)] * (0.25 + 1.5 * grey);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn layer_show(@builtin(global_invocation_id) id: vec3u) {
    let size = layer.size;
    if (any(id.xy >= size)) {
        return;
    }
    let samples = layer.samples;
    var sum = vec3f(0.0);
    for (var s = 0u; s < samples * samples; s++) {
        sum += layer_pixel(id.xy * samples + vec2u(s % samples, s / samples));
    }
    let mean = sum / f32(samples * samples);
    let kind = layer.kind;
    let is_color = kind == ADUMBRA_LAYER_COLOR || kind == ADUMBRA_LAYER_TINT;
    let shown = select(clamp(mean, vec3f(0.0), vec3f(1.0)), adumbra_srgb_encoded(mean), is_color);
    textureStore(layer_out, id.xy, vec4f(shown, 1.0));
}
