// Extrapolates depth along an axis of the screen over a texel's own surface, so that a plane seen at a
// grazing angle counts as one surface. Over a plane, inverse view depth is linear in the texel position in
// perspective; in an orthographic picture, view depth itself is.

// Returns (s, t) such that a tap i texels away with view depth z is z (1 + s i) - (own + t i) off the
// surface. In perspective that distance is measured at the texel's own view depth: both terms are multiplied
// by own / (the surface's depth at the tap), which saves one division per tap. (0, 0) yields plain depth
// differences.
//
// The slope comes from whichever of the two neighbours is nearer in depth. A view depth of 0 means that there
// is no surface. `kind` is 1 in x for perspective or in y for orthographic. `inverse_width` is the reciprocal
// of the depth difference that still counts as the same surface. A neighbour further away than that is used
// only if the other neighbour is on the opposite side of the texel in depth, as on steep planes. Otherwise an
// object one texel wide would take its background for its own surface.
fn adumbra_occlusion_run(before: f32, own: f32, after: f32, kind: vec2f, inverse_width: f32) -> vec2f {
    let back = before - own;
    let on = after - own;
    let is_before = before > 0.0 && (after <= 0.0 || abs(back) < abs(on));
    let other = select(after, before, is_before);
    let step = other - own;
    let is_steep = abs(step) * inverse_width > 1.0;
    let goes_on = before > 0.0 && after > 0.0 && back * on < 0.0;
    if (other <= 0.0 || (is_steep && !goes_on)) {
        return vec2f(0.0);
    }
    let side = select(1.0, -1.0, is_before);
    return side * kind * vec2f(own / other - 1.0, step);
}
