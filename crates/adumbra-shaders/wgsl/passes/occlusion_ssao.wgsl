// Mittring, Finding Next Gen: CryEngine 2, 2007, with the hemisphere about the normal that engines have taken since: the
// share of points near P that lie behind what is seen where they are. Numbers are radii, so that nothing depends on the
// scene's unit.
// shape: strength, exponent of the visibility, bias, range. What is seen occludes a point that it lies nearer than by more
// than the bias; it counts for smoothstep(0, 1, range / |difference of its depth and P's|), so that what lies far before P
// does not darken it.
// shape_more: how far it rises over P's tangent plane at least. That is a departure: a depth is that of a texel's centre, up
// to half a texel from the point, and on a slope the difference is the surface's own, so a bias in depth that is right for
// one slope is wrong for others.
// A tap: a point in the unit ball, in radii.

fn ambient_visibility(c: OcclusionCenter) -> f32 {
    let inverse_radius = 1.0 / c.radius_world;
    let bias = occlusion.shape.z;
    let range = occlusion.shape.w;
    let size = vec2f(occlusion.size.xy);
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < occlusion.counts.x; i++) {
        let tap = noise.taps[c.first_tap + i].xyz;
        let s = c.p + c.radius_world * select(tap, -tap, dot(tap, c.n) < 0.0);
        if (s.z <= 0.0) {
            continue;
        }
        let at = round(occlusion_texel(occlusion.ndc_from_texel, occlusion.half_view, s));
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
        if (dot(w, c.n) > occlusion.shape_more.x) {
            let near = range / max(abs(w.z), range);
            sum += near * near * (3.0 - 2.0 * near);
        }
    }
    return pow(clamp(1.0 - occlusion.shape.x * sum / max(count, 1.0), 0.0, 1.0), occlusion.shape.y);
}
