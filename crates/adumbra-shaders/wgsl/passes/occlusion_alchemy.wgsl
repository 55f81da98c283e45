// McGuire, Osman, Bukowski, Hennessy, The Alchemy Screen-Space Ambient Obscurance Algorithm, 2011, expressed
// in radii, w = v / R, so that it does not depend on the scene's unit:
//     A = max(0, 1 - (2 σ / s) Σ max(0, w·n - β z / R) / (w·w + ε))^k
// As published, only the disc of taps limits the distance of an occluder: it may be far in front of the
// surface that it occludes. Parameters: strength = 2 σ, exponent = k, bias = β, epsilon = ε. A tap is a point
// in the unit disc, uniformly distributed, in radii.

fn ambient_visibility(c: OcclusionCenter) -> f32 {
    let inverse_radius = 1.0 / c.radius_world;
    let bias = occlusion.shape.bias * c.p.z * inverse_radius;
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < occlusion.tap_count; i++) {
        let texel = c.texel + vec2i(round(noise.taps[c.first_tap + i].xy * c.radius_texels));
        if (!is_inside(texel)) {
            continue;
        }
        count += 1.0;
        let z = view_depth_at(texel);
        if (z > 0.0) {
            let w = (point_at(texel, z) - c.p) * inverse_radius;
            sum += max(dot(w, c.n) - bias, 0.0) / (dot(w, w) + occlusion.shape.epsilon);
        }
    }
    return pow(clamp(1.0 - occlusion.shape.strength * sum / max(count, 1.0), 0.0, 1.0), occlusion.shape.exponent);
}
