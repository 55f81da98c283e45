// Draws one or two pictures to a window, with one triangle over everything: the first picture, both at a
// divider, or their difference.

@group(0) @binding(0) var<uniform> present: AdumbraPresentParams;
@group(0) @binding(1) var present_first: texture_2d<f32>;
@group(0) @binding(2) var present_second: texture_2d<f32>;

@vertex
fn present_vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32(index & 1u), f32(index >> 1u));
    return vec4f(4.0 * corner - 1.0, 0.0, 1.0);
}

fn present_brightness(c: vec3f) -> f32 {
    return dot(c, vec3f(0.2126, 0.7152, 0.0722));
}

// Returns `too_dark` where the first picture is brighter, `too_bright` where the second is, with a strength
// set by the gain; elsewhere the first picture, darkened and grey.
fn present_difference(first: vec3f, second: vec3f) -> vec3f {
    let brighter = present_brightness(first) - present_brightness(second);
    let wrong = select(present.too_bright, present.too_dark, brighter > 0.0);
    let grey = vec3f(0.12 + 0.4 * present_brightness(first));
    return mix(grey, wrong, clamp(abs(brighter) * present.gain, 0.0, 1.0));
}

@fragment
fn present_fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = min(vec2u(position.xy), textureDimensions(present_first) - 1u);
    let kind = present.kind;
    let divider = present.divider;
    var color = textureLoad(present_first, pixel, 0).rgb;
    if (kind != ADUMBRA_PRESENT_FIRST) {
        let second = textureLoad(present_second, min(pixel, textureDimensions(present_second) - 1u), 0).rgb;
        if (kind == ADUMBRA_PRESENT_DIFFERENCE) {
            color = present_difference(color, second);
        } else if (pixel.x >= divider) {
            color = second;
        }
        if (kind == ADUMBRA_PRESENT_SPLIT && pixel.x + 1u >= divider && pixel.x <= divider) {
            color = vec3f(1.0);
        }
    }
    return vec4f(select(color, adumbra_srgb_decoded(color), present.window_encodes == 1u), 1.0);
}
