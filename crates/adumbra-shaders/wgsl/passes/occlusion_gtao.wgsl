// Jimenez, Wu, Pesce, Jarabo, Practical Real-Time Strategies for Accurate Indirect Occlusion, 2016, as
// implemented by XeGTAO (Intel, 2021). In slices that contain the line of sight, finds the horizon on either
// side, and integrates the cosine-weighted part of the hemisphere between the two. From a fraction of the
// radius to its end, horizons fall off to the tangent plane. Distances along the view are scaled up, so that
// thin objects fade. Departures: the sum over slices is divided by its value without occluders, which is not
// 1 for few slices. A side is weighted by the number of its steps that are inside the picture. Horizons are
// measured from the tangent of each tap's own slice (rise_over_tangent). There are no depth mips. Parameters:
// falloff_slope = 1 / (1 - falloff), depth_stretch = 1 + thin, exponent. Taps are as in
// passes/occlusion_march.wgsl. Their distances are already raised to the power that concentrates them near P.

// Abramowitz and Stegun, Handbook of Mathematical Functions, 4.4.45; the error is below 7e-5.
fn acos_near(x: f32) -> f32 {
    let y = abs(x);
    let angle = sqrt(max(1.0 - y, 0.0)) * (((-0.0187293 * y + 0.0742610) * y - 0.2121144) * y + 1.5707288);
    return select(angle, 3.14159265 - angle, x < 0.0);
}

// The paper's inner integral ∫ cos(θ - γ) sin θ dθ from the direction to the eye to a horizon, times the
// length of the normal's projection into the slice. n_slice is that projection: its components along the
// direction to the eye, and across it towards this side. In terms of the horizon's angle h, 1/4 (cos γ + 2 h
// sin γ - cos(2 h - γ)) becomes 1/2 (cos γ sin² h + sin γ (h - sin h cos h)).
fn arc(n_slice: vec2f, cos_h: f32) -> f32 {
    let sin_h_2 = max(1.0 - cos_h * cos_h, 0.0);
    return 0.5 * (n_slice.x * sin_h_2 + n_slice.y * (acos_near(cos_h) - sqrt(sin_h_2) * cos_h));
}

fn ambient_visibility(c: OcclusionCenter) -> f32 {
    let inverse_radius = 1.0 / c.radius_world;
    let to_eye = towards_eye(c);
    let facing = max(dot(c.n, to_eye), 0.0);
    let steps = occlusion.step_count;
    let sides = min(occlusion.tap_count / steps, 2u);
    var seen = 0.0;
    var open = 0.0;
    for (var first = 0u; first * sides < occlusion.tap_count; first += steps) {
        let along = noise.taps[c.first_tap + first].xy;
        let across = normalize(vec3f(along, 0.0) - to_eye * dot(vec3f(along, 0.0), to_eye));
        let n_across = dot(c.n, across);
        let inverse_length = inverseSqrt(max(facing * facing + n_across * n_across, 1e-12));
        for (var side = 0u; side < sides; side++) {
            let sign = 1.0 - 2.0 * f32(side);
            var rise = 0.0;
            var inside = 0.0;
            for (var step = 0u; step < steps; step++) {
                let tap = noise.taps[c.first_tap + first + step];
                let texel = march_texel(c, sign * tap.xy, select(tap.z, tap.w, side == 1u));
                if (!is_inside(texel)) {
                    break;
                }
                inside += 1.0;
                let z = view_depth_at(texel);
                if (z <= 0.0) {
                    continue;
                }
                let w = (point_at(texel, z) - c.p) * inverse_radius;
                let far = length(w * vec3f(1.0, 1.0, occlusion.shape.depth_stretch));
                if (far < 1.0) {
                    let weight = min((1.0 - far) * occlusion.shape.falloff_slope, 1.0);
                    rise = max(rise, weight * rise_over_tangent(w, dot(w, w), c.n, to_eye, facing));
                }
            }
            let n_slice = vec2f(facing, sign * n_across);
            let cos_tangent = -n_slice.y * inverse_length;
            open += inside * arc(n_slice, cos_tangent);
            seen += inside * arc(n_slice, min(cos_tangent + rise, 1.0));
        }
    }
    let visibility = select(1.0, seen / open, open > 1e-6);
    return pow(clamp(visibility, 0.0, 1.0), occlusion.shape.exponent);
}
