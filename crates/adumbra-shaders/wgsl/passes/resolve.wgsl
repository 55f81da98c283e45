// Evaluates a technique for each pixel of the G-buffer, one thread per pixel. Sky pixels are 1, surfaces that
// face away from the sun 0.

@group(0) @binding(0) var<uniform> frame: AdumbraFrame;
@group(0) @binding(1) var gbuffer_depth: texture_depth_2d;
@group(0) @binding(2) var gbuffer_normal: texture_2d<f32>;
@group(0) @binding(3) var shadow_out: texture_storage_2d<r32float, write>;

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn resolve(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if (any(pixel >= frame.size)) {
        return;
    }
    let depth = textureLoad(gbuffer_depth, pixel, 0);
    var factor = 1.0;
    if (depth > 0.0) {
        let s = adumbra_frame_surface(frame, pixel, depth, textureLoad(gbuffer_normal, pixel, 0).xyz);
        factor = 0.0;
        if (dot(s.normal, s.towards_sun) > 0.0) {
            factor = adumbra_shadow_factor(s);
        }
    }
    textureStore(shadow_out, pixel, vec4f(factor, 0.0, 0.0, 0.0));
}

// Evaluates a technique for every surface, whichever way it faces. Sky pixels are -1.
@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn resolve_all(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if (any(pixel >= frame.size)) {
        return;
    }
    let depth = textureLoad(gbuffer_depth, pixel, 0);
    var answer = -1.0;
    if (depth > 0.0) {
        answer = adumbra_shadow_factor(adumbra_frame_surface(frame, pixel, depth, textureLoad(gbuffer_normal, pixel, 0).xyz));
    }
    textureStore(shadow_out, pixel, vec4f(answer, 0.0, 0.0, 0.0));
}
