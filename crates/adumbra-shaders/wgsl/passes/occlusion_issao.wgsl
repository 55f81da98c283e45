// Qiu, Li, Wu, Shi, Zhang, Improved Screen Space Ambient Occlusion, Chinese Journal of Computers 37(3), 2014: 4.1 and 4.2, with the lost
// equation (6) rebuilt and written in radii, w = v / R, so that it does not depend on the scene's unit:
//     A = clamp((2 λ φ / s) Σ max(0, w·n - ψ min(z / R, z_cap)) / (w·w + σ), 0, 1), terms with w·w >= 1 counting nothing.
// shape: 2 λ φ, ψ, z_cap, σ. shape_more: exponent of the factor (1 - w·w) that the second reading puts on each term (0 in the first); 1 with
// the attenuation, 0 for v normalised as before it (Fig. 4).
// A tap: C(e1, e2) of (1), its reach in radii.

// Taps left at a distance, where the disc covers few texels: a quarter less for each halving from 16.
fn taps_at(radius_texels: f32) -> u32 {
    let level = select(select(select(3u, 2u, radius_texels >= 4.0), 1u, radius_texels >= 8.0), 0u, radius_texels >= 16.0);
    let parts = max(4u - level, occlusion.counts.w);
    return max(occlusion.counts.x * parts / 4u, 1u);
}

fn ambient_visibility(c: OcclusionCenter) -> f32 {
    let inverse_radius = 1.0 / c.radius_world;
    let bias = occlusion.shape.y * min(c.p.z * inverse_radius, occlusion.shape.z);
    var sum = 0.0;
    var count = 0.0;
    // Texels taken, of the 5 × 5 about the middle, where taps meet; the middle itself is.
    var taken = 1u << 12u;
    let taps = taps_at(c.radius_texels);
    for (var i = 0u; i < taps; i++) {
        let offset = vec2i(round(noise.taps[c.first_tap + i].xy * c.radius_texels));
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
        count += 1.0;
        let z = view_depth_at(texel);
        if (z <= 0.0) {
            continue;
        }
        let w = (point_at(texel, z) - c.p) * inverse_radius;
        let ww = dot(w, w);
        if (ww < 1.0) {
            let height = max(dot(w, c.n) - bias, 0.0);
            sum += issao_term(height, ww);
        }
    }
    return 1.0 - clamp(occlusion.shape.x * sum / max(count, 1.0), 0.0, 1.0);
}

fn issao_term(height: f32, ww: f32) -> f32 {
    if (occlusion.shape_more.y == 0.0) {
        return height * inverseSqrt(ww + occlusion.shape.w);
    }
    var term = height / (ww + occlusion.shape.w);
    if (occlusion.shape_more.x > 0.0) {
        term *= pow(1.0 - ww, occlusion.shape_more.x);
    }
    return term;
}
