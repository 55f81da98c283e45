// Weights of the screen-space blur: the Gaussian, and how much the shadow of one visible point applies to
// another.

fn adumbra_blur_gauss(distance: f32, sigma: f32) -> f32 {
    let d = distance / sigma;
    return exp(-0.5 * d * d);
}

// Width of a pixel at view depth z, world units.
fn adumbra_blur_pixel_world(frame: AdumbraFrame, z: f32) -> f32 {
    return 2.0 * (z * length(frame.ray_y) + length(frame.origin_y)) / f32(frame.size.y);
}

// Returns 1 if both points are on one plane, and 0 if either is tolerance_world or more off the other's plane
// or the normals differ by 90° or more.
fn adumbra_blur_same_surface(a: AdumbraSurface, b: AdumbraSurface, tolerance_world: f32) -> f32 {
    let between = b.p_relative - a.p_relative;
    let off = max(abs(dot(a.normal, between)), abs(dot(b.normal, between)));
    let c = max(dot(a.normal, b.normal), 0.0);
    let c4 = c * c * c * c;
    return max(1.0 - off / tolerance_world, 0.0) * c4 * c4;
}
