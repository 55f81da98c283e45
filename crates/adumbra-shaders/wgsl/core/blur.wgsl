// Weights of the screen-space blur: the Gaussian, and how much of one visible point's shade holds for another.

fn blur_gauss(distance: f32, sigma: f32) -> f32 {
    let d = distance / sigma;
    return exp(-0.5 * d * d);
}

// Width of a pixel at view depth z, world units.
fn blur_pixel_world(frame: Frame, z: f32) -> f32 {
    return 2.0 * (z * length(frame.ray_y.xyz) + length(frame.origin_y.xyz)) / f32(frame.size.y);
}

// 1 where both points lie on one plane, 0 where either lies tolerance_world or more off the other's plane or they face apart by 90°.
fn blur_same_surface(a: Surface, b: Surface, tolerance_world: f32) -> f32 {
    let between = b.p_relative - a.p_relative;
    let off = max(abs(dot(a.normal, between)), abs(dot(b.normal, between)));
    let c = max(dot(a.normal, b.normal), 0.0);
    let c4 = c * c * c * c;
    return max(1.0 - off / tolerance_world, 0.0) * c4 * c4;
}
