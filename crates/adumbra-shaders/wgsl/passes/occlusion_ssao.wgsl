// Mittring, Finding Next Gen: CryEngine 2, 2007, with the hemisphere around the normal that engines have
// adopted since: the fraction of points near P that are behind the visible surface at their screen position.
// Distances are in radii, so that nothing depends on the scene's unit. Parameters: strength, exponent, bias,
// range. The visible surface occludes a point if it is nearer than the point by more than the bias. It is
// weighted by smoothstep(0, 1, range / |difference of its depth and P's|), so that surfaces far in front of P
// do not darken it. min_rise: the smallest height of the surface above P's tangent plane. This is a
// departure: a stored depth is that of a texel's centre, up to half a texel from the point. On a slope the
// depth difference is then the surface's own, so a depth bias that is right for one slope is wrong for
// others. A tap is a point in the unit ball, in radii.

fn ambient_visibility(c: OcclusionCenter) -> f32 {
    let inverse_radius = 1.0 / c.radius_world;
    let bias = occlusion.shape.bias;
    let range = occlusion.shape.range;
    let size = vec2f(occlusion.size);
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < occlusion.tap_count; i++) {
        let tap = noise.taps[c.first_tap + i].xyz;
        let s = c.p + c.radius_world * select(tap, -tap, dot(tap, c.n) < 0.0);
        if (s.z <= 0.0) {
            continue;
        }
        let at = round(adumbra_occlusion_texel(occlusion.view, s));
        if (!(all(at >= vec2f(0.0)) && all(at < size))) {
            continue;
        }
        count += 1.0;
        let texel = vec2i(at);
        let z = view_depth_at(texel);
        if (z <= 0.0 || (s.z - z) * inverse_radius <= bias) {
            continue;
        }
        let w = (point_at(texel, z) - c.p) * inverse_radius;
        if (dot(w, c.n) > occlusion.shape.min_rise) {
            let near = range / max(abs(w.z), range);
            sum += near * near * (3.0 - 2.0 * near);
        }
    }
    return pow(clamp(1.0 - occlusion.shape.strength * sum / max(count, 1.0), 0.0, 1.0), occlusion.shape.exponent);
}
