// Qiu, Li, Wu, Shi, Zhang, Improved Screen Space Ambient Occlusion, Chinese Journal of Computers 37(3), 2014:
// 4.1 and 4.2, with the lost equation (6) reconstructed and expressed in radii, w = v / R, so that it does
// not depend on the scene's unit:
//     A = clamp((2 λ / s) Σ max(0, w·n - ψ min(z / R, z_cap)) / (w·w + σ), 0, 1)
//     visibility = (1 - A)^(1 / φ)
// over the s taps that are inside the picture and on texels not yet sampled; other taps are skipped. Outside
// R a term is 0, and its tap counts as open. Readings 1 and 2 of φ differ from this formula: φ is a factor
// next to λ, or 1 / φ is the exponent of (1 - w·w) on each term. The terms are in separate files, of which a
// pass includes one. Departure: a surface in front of the sphere of radius R hides what is inside it. Such a
// tap counts as if at the point where its line of sight enters the sphere, attenuated by 1 / |w|, the falloff
// of (5). Without the departure such taps are unknown and skipped, and the ground behind objects is too
// bright. Parameters: strength = 2 λ, bias = ψ, max_bias_depth = z_cap, epsilon = σ, falloff_exponent =
// exponent of (1 - w·w), exponent = that of the visibility, hides_from_outside = 1 with the departure. A tap
// is C(e1, e2) of (1), in radii; taps are sorted by distance.

// Returns the number of taps for a disc of this radius: one quarter fewer for each halving below 16 texels,
// since a small disc covers few texels.
fn taps_at(radius_texels: f32) -> u32 {
    let lost = u32(radius_texels < 16.0) + u32(radius_texels < 8.0) + u32(radius_texels < 4.0);
    return max(occlusion.tap_count * max(4u - lost, occlusion.min_quarters) / 4u, 1u);
}

fn ambient_visibility(c: OcclusionCenter) -> f32 {
    let inverse_radius = 1.0 / c.radius_world;
    let bias = occlusion.shape.bias * min(c.p.z * inverse_radius, occlusion.shape.max_bias_depth);
    let hides = occlusion.shape.hides_from_outside == 1u;
    let taps = taps_at(c.radius_texels);
    let stride = (occlusion.tap_count << 16u) / taps;
    var sum = 0.0;
    var count = 0.0;
    // Taps proceed outwards along a spiral, so two taps on the same texel are consecutive.
    var before = vec2i(0);
    for (var i = 0u; i < taps; i++) {
        let offset = vec2i(round(noise.taps[c.first_tap + ((i * stride) >> 16u)].xy * c.radius_texels));
        let texel = c.texel + offset;
        let is_new = any(offset != before);
        before = offset;
        if (!(is_new && is_inside(texel))) {
            continue;
        }
        let z = view_depth_at(texel);
        var w = (point_at(texel, z) - c.p) * inverse_radius;
        let ww = dot(w, w);
        let outside = ww >= 1.0;
        let is_sky = z <= 0.0;
        let darkens = !outside || (hides && w.z < 0.0);
        let counts = is_sky || darkens || w.z > 0.0;
        w.z = select(w.z, -sqrt(max(1.0 - dot(w.xy, w.xy), 0.0)), outside);
        let term = issao_term(dot(w, c.n), min(ww, 1.0), bias) * inverseSqrt(max(ww, 1.0));
        count += f32(counts);
        sum += select(0.0, term, darkens && !is_sky);
    }
    let a = clamp(occlusion.shape.strength * sum / max(count, 1.0), 0.0, 1.0);
    return pow(1.0 - a, occlusion.shape.exponent);
}
