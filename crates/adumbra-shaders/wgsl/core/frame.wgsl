// From a pixel and its stored depth to the point behind it. The depth convention is Frame's.

fn frame_view_depth(frame: Frame, depth: f32) -> f32 {
    let k = frame.depth_to_z;
    return (k.x + k.y * depth) / (k.z + k.w * depth);
}

// Of the pixel's centre, -1 to 1, y up.
fn frame_ndc(frame: Frame, pixel: vec2u) -> vec2f {
    let uv = (vec2f(pixel) + 0.5) / vec2f(frame.size.xy);
    return vec2f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
}

// Direction of the pixel's ray; its part along forward is 1.
fn frame_ray(frame: Frame, ndc: vec2f) -> vec3f {
    return frame.ray.xyz + ndc.x * frame.ray_x.xyz + ndc.y * frame.ray_y.xyz;
}

fn frame_surface(frame: Frame, pixel: vec2u, depth: f32, normal: vec3f) -> Surface {
    let z = frame_view_depth(frame, depth);
    let ndc = frame_ndc(frame, pixel);
    let origin = frame.origin.xyz + ndc.x * frame.origin_x.xyz + ndc.y * frame.origin_y.xyz;
    var s: Surface;
    s.p_relative = origin + z * frame_ray(frame, ndc);
    s.normal = normalize(normal);
    s.towards_sun = frame.towards_sun.xyz;
    s.view_depth = z;
    s.pixel = pixel;
    return s;
}
