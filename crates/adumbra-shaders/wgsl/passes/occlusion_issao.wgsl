// Qiu, Li, Wu, Shi, Zhang, Improved Screen Space Ambient Occlusion, Chinese Journal of Computers 37(3), 2014: 4.1 and 4.2, with the lost
// equation (6) rebuilt and written in radii, w = v / R, so that it does not depend on the scene's unit:
//     A = clamp((2 λ / s) Σ max(0, w·n - ψ min(z / R, z_cap)) / (w·w + σ), 0, 1),    visibility (1 - A)^(1 / φ)
// over the s taps that are in the picture and on texels not yet taken; others are skipped. Outside R a term counts nothing, and its tap is
// open. Readings 1 and 2 of φ: a factor beside λ; an exponent, 1 / φ, of (1 - w·w) on each term. A term is a file of its own, of
// which the pass takes one.
// Departure: what lies before the sphere of R hides what is in it. Such a tap counts from the sphere's surface, where its line of sight
// enters, less by 1 / |w|, as (5) falls off; without it such taps are unknown and skipped, and the ground behind things is too light.
// shape: 2 λ, ψ, z_cap, σ. shape_more: exponent of (1 - w·w); exponent of the visibility; 0; 1 with the departure.
// A tap: C(e1, e2) of (1), in radii, by distance.

// Taps at a distance, where the disc covers few texels: a quarter less for each halving from 16 texels.
fn taps_at(radius_texels: f32) -> u32 {
    let lost = u32(radius_texels < 16.0) + u32(radius_texels < 8.0) + u32(radius_texels < 4.0);
    return max(occlusion.counts.x * max(4u - lost, occlusion.counts.w) / 4u, 1u);
}

fn ambient_visibility(c: OcclusionCenter) -> f32 {
    let inverse_radius = 1.0 / c.radius_world;
    let bias = occlusion.shape.y * min(c.p.z * inverse_radius, occlusion.shape.z);
    let hides = occlusion.shape_more.w > 0.0;
    let taps = taps_at(c.radius_texels);
    let stride = (occlusion.counts.x << 16u) / taps;
    var sum = 0.0;
    var count = 0.0;
    // Taps go outwards along a spiral: two that meet on a texel follow each other.
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
    let a = clamp(occlusion.shape.x * sum / max(count, 1.0), 0.0, 1.0);
    return pow(1.0 - a, occlusion.shape_more.y);
}
