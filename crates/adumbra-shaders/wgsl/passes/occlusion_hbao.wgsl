// Bavoil, Sainz, Dimitrov, Image-Space Horizon-Based Ambient Occlusion, 2008: in each direction the sine of the horizon's
// elevation less that of the tangent plane's, gathered step by step: what a step adds to the horizon counts for 1 -
// r^falloff, r its distance in radii, and steps out of reach do not raise it. The mean over directions is the occlusion.
// Departures: elevations are over the plane across the line of sight, not across the camera's axis; the tangent is that of
// each tap's own slice (rise_over_tangent) instead of the direction's, so that no bias is needed against slopes.
// shape: strength, exponent of the visibility, bias (a horizon counts from where it rises that much over the tangent),
// falloff / 2.
// Taps as in passes/occlusion_march.wgsl.

fn ambient_visibility(c: OcclusionCenter) -> f32 {
    let inverse_radius = 1.0 / c.radius_world;
    let to_eye = towards_eye(c);
    let facing = max(dot(c.n, to_eye), 0.0);
    let steps = occlusion.counts.y;
    var sum = 0.0;
    var count = 0.0;
    for (var first = 0u; first < occlusion.counts.x; first += steps) {
        var horizon = occlusion.shape.z;
        var occluded = 0.0;
        // A direction counts for as many steps of it as lie in the picture.
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
                    occluded += (rise - horizon) * (1.0 - pow(ww, occlusion.shape.w));
                    horizon = rise;
                }
            }
        }
        sum += occluded * inside;
        count += inside;
    }
    return pow(clamp(1.0 - occlusion.shape.x * sum / max(count, 1.0), 0.0, 1.0), occlusion.shape.y);
}
