// Reconstructs the visible point from a pixel and its stored depth. AdumbraFrame documents the depth
// convention.

// Returns the NDC of the pixel's centre, -1 to 1, y up.
fn adumbra_frame_ndc(frame: AdumbraFrame, pixel: vec2u) -> vec2f {
    let uv = (vec2f(pixel) + 0.5) / vec2f(frame.size);
    return vec2f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
}

// Returns the direction of the pixel's ray; its component along forward is 1.
fn adumbra_frame_ray(frame: AdumbraFrame, ndc: vec2f) -> vec3f {
    return frame.ray + ndc.x * frame.ray_x + ndc.y * frame.ray_y;
}

fn adumbra_frame_surface(frame: AdumbraFrame, pixel: vec2u, depth: f32, normal: vec3f) -> AdumbraSurface {
    let z = adumbra_stored_view_depth(frame.depth_to_z, depth);
    let ndc = adumbra_frame_ndc(frame, pixel);
    let origin = frame.origin + ndc.x * frame.origin_x + ndc.y * frame.origin_y;
    var s: AdumbraSurface;
    s.p_relative = origin + z * adumbra_frame_ray(frame, ndc);
    s.normal = normalize(normal);
    s.towards_sun = frame.towards_sun;
    s.view_depth = z;
    s.pixel = pixel;
    return s;
}
