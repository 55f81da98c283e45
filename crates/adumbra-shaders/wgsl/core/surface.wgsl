// A visible point, the input of every shadow technique. A technique is a function
//     fn adumbra_shadow_factor(s: AdumbraSurface) -> f32      visibility of the sun, 1 = lit
// in a file of passes/ that also holds its bindings: group 1 for baked voxels, group 2 for shadow maps.
// passes/resolve.wgsl calls it for each pixel, passes/points.wgsl for each point of a list.

struct AdumbraSurface {
    // World position minus the frame's anchor.
    p_relative: vec3f,
    // Unit vector, towards the viewer; zero if unknown.
    normal: vec3f,
    // Unit vector, towards the sun.
    towards_sun: vec3f,
    // Distance along the camera's forward direction.
    view_depth: f32,
    // Pixel at which the point appears on the screen.
    pixel: vec2u,
}

// Returns the tangent of the angle between normal and light, at most ADUMBRA_MAX_SLOPE; 0 without a normal.
fn adumbra_surface_slope(s: AdumbraSurface) -> f32 {
    let n_dot_l = dot(s.normal, s.towards_sun);
    let tangent = length(s.normal - n_dot_l * s.towards_sun);
    if (tangent == 0.0) {
        return 0.0;
    }
    return tangent / max(n_dot_l, tangent / ADUMBRA_MAX_SLOPE);
}

// Returns the distance by which a receiver moves along the light, in texels: constant plus slope-scaled bias.
fn adumbra_bias_along_light(bias: AdumbraReceiverBias, slope: f32) -> f32 {
    return bias.constant_texels + bias.slope_texels * slope;
}
