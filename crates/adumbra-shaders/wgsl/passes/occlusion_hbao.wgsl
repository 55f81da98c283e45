// Bavoil, Sainz, Dimitrov, Image-Space Horizon-Based Ambient Occlusion, 2008. For each direction, the
// occlusion is the sine of the horizon's elevation minus that of the tangent plane's, accumulated step by
// step: each increase of the horizon is weighted by 1 - r^falloff, where r is the step's distance in radii.
// Steps beyond the radius do not raise the horizon. The mean over all directions is the occlusion.
// Departures: elevations are relative to the plane perpendicular to the line of sight, not to the camera's
// axis. The tangent is that of each tap's own slice (rise_over_tangent) instead of the direction's, so that
// slopes need no bias. Parameters: strength, exponent, bias (rise over the tangent at which a horizon begins
// to count), falloff_exponent = falloff / 2. Taps are as in passes/occlusion_march.wgsl.

fn ambient_visibility(c: OcclusionCenter) -> f32 {
    let inverse_radius = 1.0 / c.radius_world;
    let to_eye = towards_eye(c);
    let facing = max(dot(c.n, to_eye), 0.0);
    let steps = occlusion.step_count;
    var sum = 0.0;
    var count = 0.0;
    for (var first = 0u; first < occlusion.tap_count; first += steps) {
        var horizon = occlusion.shape.bias;
        var occluded = 0.0;
        // A direction is weighted by the number of its steps that are inside the picture.
        var inside = 0.0;
        for (var step = 0u; step < steps; step++) {
            let tap = noise.taps[c.first_tap + first + step];
            let texel = march_texel(c, tap.xy, tap.z);
            if (!is_inside(texel)) {
                break;
            }
            inside += 1.0;
            let z = view_depth_at(texel);
            if (z <= 0.0) {
                continue;
            }
            let w = (point_at(texel, z) - c.p) * inverse_radius;
            let ww = dot(w, w);
            if (ww < 1.0) {
                let rise = rise_over_tangent(w, ww, c.n, to_eye, facing);
                if (rise > horizon) {
                    occluded += (rise - horizon) * (1.0 - pow(ww, occlusion.shape.falloff_exponent));
                    horizon = rise;
                }
            }
        }
        sum += occluded * inside;
        count += inside;
    }
    return pow(clamp(1.0 - occlusion.shape.strength * sum / max(count, 1.0), 0.0, 1.0), occlusion.shape.exponent);
}
