// A visible point, as every shadow technique takes it. A technique is a function
//     fn shadow_factor(s: Surface) -> f32      visibility of the sun, 1 = lit
// in a file of passes/ that holds its bindings: group 1 for baked voxels, group 2 for shadow maps. passes/resolve.wgsl calls it for
// each pixel, passes/points.wgsl for each point of a list.

struct Surface {
    // World position less the frame's anchor.
    p_relative: vec3f,
    // Unit, towards the viewer; zero where none is known.
    normal: vec3f,
    // Unit, towards the sun.
    towards_sun: vec3f,
    // Distance along the camera's forward direction.
    view_depth: f32,
    // Where it appears on the screen.
    pixel: vec2u,
}

// Tangent of the angle between normal and light, at most MAX_SLOPE; 0 without a normal.
fn surface_slope(s: Surface) -> f32 {
    let n_dot_l = dot(s.normal, s.towards_sun);
    let tangent = length(s.normal - n_dot_l * s.towards_sun);
    if (tangent == 0.0) {
        return 0.0;
    }
    return tangent / max(n_dot_l, tangent / MAX_SLOPE);
}

// How far along the light a receiver moves, in texels: constant and slope term of the bias.
fn bias_along_light(bias: vec4f, slope: f32) -> f32 {
    return bias.x + bias.y * slope;
}
