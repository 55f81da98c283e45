// Lights the G-buffer with a simple sun and sky. The shadow factor applies to the sun, ambient visibility to
// the sky light only. One thread per pixel. Lighting is linear, output is sRGB. The arithmetic is that of the
// CPU renderer (adumbra_truth::picture).

@group(0) @binding(0) var<uniform> frame: AdumbraFrame;
@group(0) @binding(1) var gbuffer_depth: texture_depth_2d;
@group(0) @binding(2) var gbuffer_normal: texture_2d<f32>;
@group(0) @binding(3) var gbuffer_color: texture_2d<f32>;
@group(0) @binding(4) var shadow_factors: texture_2d<f32>;
@group(0) @binding(5) var color_out: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(6) var<uniform> light: AdumbraCompositeParams;
// Has the frame's size, or is a single texel for all pixels.
@group(0) @binding(7) var ambient_visibilities: texture_2d<f32>;

// Tone curve with a gentle shoulder, so that sunlit white stays below white.
fn tone(c: vec3f) -> vec3f {
    return c * (1.0 + c / 4.0) / (1.0 + c);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn composite(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if (any(pixel >= frame.size)) {
        return;
    }
    let depth = textureLoad(gbuffer_depth, pixel, 0);
    var color: vec3f;
    if (depth == 0.0) {
        let ray = normalize(adumbra_frame_ray(frame, adumbra_frame_ndc(frame, pixel)));
        color = light.sky_color * (1.25 - 0.5 * clamp(ray.y * 0.5 + 0.5, 0.0, 1.0));
    } else {
        let normal = normalize(textureLoad(gbuffer_normal, pixel, 0).xyz);
        let up = normal.y * 0.5 + 0.5;
        let ambient = light.sky_color * up + light.ground_color * (1.0 - up);
        let n_dot_l = max(dot(normal, frame.towards_sun), 0.0);
        let sun = light.sun_color * n_dot_l * textureLoad(shadow_factors, pixel, 0).x;
        let open = textureLoad(ambient_visibilities, min(pixel, textureDimensions(ambient_visibilities) - 1u), 0).x;
        color = textureLoad(gbuffer_color, pixel, 0).rgb * (ambient * open + sun);
    }
    textureStore(color_out, pixel, vec4f(adumbra_srgb_encoded(tone(color)), 1.0));
}
