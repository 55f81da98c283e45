// Qiu, Li, Wu, Shi, Zhang, Improved Screen Space Ambient Occlusion, Chinese Journal of Computers 37(3), 2014: 4.1 and 4.2, with the lost
// equation (6) rebuilt and written in radii, w = v / R, so that it does not depend on the scene's unit:
//     A = clamp((2 λ φ / s) Σ max(0, w·n - ψ min(z / R, z_cap)) / (w·w + σ), 0, 1)
// over the s taps that are within the picture, on texels not yet taken, and within R (w·w < 1): others are skipped.
// shape: 2 λ φ, ψ, z_cap, σ. shape_more: exponent of the factor (1 - w·w) of each term, 0 for none; exponent of A; 1 with the attenuation,
// 0 for v normalised, as before it (Fig. 4).
// A tap: C(e1, e2) of (1), in radii, by distance.

// Taps at a distance, where the disc covers few texels: a quarter less for each halving from 16 texels.
fn taps_at(radius_texels: f32) -> u32 {
    let lost = u32(radius_texels < 16.0) + u32(radius_texels < 8.0) + u32(radius_texels < 4.0);
    return max(occlusion.counts.x * max(4u - lost, occlusion.counts.w) / 4u, 1u);
}

fn issao_term(w: vec3f, ww: f32, n: vec3f, bias: f32) -> f32 {
    if (occlusion.shape_more.z == 0.0) {
        return max(dot(w, n), 0.0) * inverseSqrt(max(ww, 1e-12));
    }
    var term = max(dot(w, n) - bias, 0.0) / (ww + occlusion.shape.w);
    if (occlusion.shape_more.x > 0.0) {
        term *= pow(1.0 - ww, occlusion.shape_more.x);
    }
    return term;
}

fn ambient_visibility(c: OcclusionCenter) -> f32 {
    let inverse_radius = 1.0 / c.radius_world;
    let bias = occlusion.shape.y * min(c.p.z * inverse_radius, occlusion.shape.z);
    var sum = 0.0;
    var count = 0.0;
    // Texels taken of the 5 × 5 about the middle, where taps meet; the middle itself is.
    var taken = 1u << 12u;
    let taps = taps_at(c.radius_texels);
    for (var i = 0u; i < taps; i++) {
        let tap = noise.taps[c.first_tap + i * occlusion.counts.x / taps];
        let offset = vec2i(round(tap.xy * c.radius_texels));
        if (all(abs(offset) <= vec2i(2))) {
            let bit = 1u << u32(offset.y * 5 + offset.x + 12);
            if ((taken & bit) != 0u) {
                continue;
            }
            taken |= bit;
        }
        let texel = c.texel + offset;
        if (!is_inside(texel)) {
            continue;
        }
        let z = view_depth_at(texel);
        if (z <= 0.0) {
            count += 1.0;
            continue;
        }
        let w = (point_at(texel, z) - c.p) * inverse_radius;
        let ww = dot(w, w);
        if (ww < 1.0) {
            count += 1.0;
            sum += issao_term(w, ww, c.n, bias);
        }
    }
    let a = clamp(occlusion.shape.x * sum / max(count, 1.0), 0.0, 1.0);
    return 1.0 - pow(a, occlusion.shape_more.y);
}
