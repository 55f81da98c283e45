// McGuire, Osman, Bukowski, Hennessy, The Alchemy Screen-Space Ambient Obscurance Algorithm, 2011, written in radii, w = v / R,
// so that it does not depend on the scene's unit:
//     A = max(0, 1 - (2 σ / s) Σ max(0, w·n - β z / R) / (w·w + ε))^k
// As published, nothing but the disc that taps lie in limits how far off an occluder may be: what lies behind others may be
// far before P.
// shape: 2 σ, k, β, ε.
// A tap: a point of the unit disc, as many everywhere, in radii.

fn ambient_visibility(c: OcclusionCenter) -> f32 {
    let inverse_radius = 1.0 / c.radius_world;
    let bias = occlusion.shape.z * c.p.z * inverse_radius;
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < occlusion.counts.x; i++) {
        let texel = c.texel + vec2i(round(noise.taps[c.first_tap + i].xy * c.radius_texels));
        if (!is_inside(texel)) {
            continue;
        }
        count += 1.0;
        let z = view_depth_at(texel);
        if (z > 0.0) {
            let w = (point_at(texel, z) - c.p) * inverse_radius;
            sum += max(dot(w, c.n) - bias, 0.0) / (dot(w, w) + occlusion.shape.w);
        }
    }
    return pow(clamp(1.0 - occlusion.shape.x * sum / max(count, 1.0), 0.0, 1.0), occlusion.shape.y);
}
