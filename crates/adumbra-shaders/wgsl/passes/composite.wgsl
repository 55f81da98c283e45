// A plain sun and sky on the G-buffer, with the shadow factor and, on the light of the sky alone, ambient visibility; one thread a pixel.
// Linear light in, sRGB out: the same arithmetic as the CPU renderer's (adumbra::picture).

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var gbuffer_depth: texture_depth_2d;
@group(0) @binding(2) var gbuffer_normal: texture_2d<f32>;
@group(0) @binding(3) var gbuffer_color: texture_2d<f32>;
@group(0) @binding(4) var shadow_factors: texture_2d<f32>;
@group(0) @binding(5) var color_out: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(6) var<uniform> light: CompositeParams;
// Of the frame's size, or a single texel for all.
@group(0) @binding(7) var ambient_visibilities: texture_2d<f32>;

// A gentle shoulder, so that sunlit white stays below white.
fn tone(c: vec3f) -> vec3f {
    return c * (1.0 + c / 4.0) / (1.0 + c);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn composite(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if (any(pixel >= frame.size.xy)) {
        return;
    }
    let depth = textureLoad(gbuffer_depth, pixel, 0);
    var color: vec3f;
    if (depth == 0.0) {
        let ray = normalize(frame_ray(frame, frame_ndc(frame, pixel)));
        color = light.sky_color.rgb * (1.25 - 0.5 * clamp(ray.y * 0.5 + 0.5, 0.0, 1.0));
    } else {
        let normal = normalize(textureLoad(gbuffer_normal, pixel, 0).xyz);
        let up = normal.y * 0.5 + 0.5;
        let ambient = light.sky_color.rgb * up + light.ground_color.rgb * (1.0 - up);
        let n_dot_l = max(dot(normal, frame.towards_sun.xyz), 0.0);
        let sun = light.sun_color.rgb * n_dot_l * textureLoad(shadow_factors, pixel, 0).x;
        let open = textureLoad(ambient_visibilities, min(pixel, textureDimensions(ambient_visibilities) - 1u), 0).x;
        color = textureLoad(gbuffer_color, pixel, 0).rgb * (ambient * open + sun);
    }
    textureStore(color_out, pixel, vec4f(srgb_encoded(tone(color)), 1.0));
}
