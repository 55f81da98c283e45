// Depth along an axis of the screen: how it would run on over a texel's own surface, so that a plane seen at a grazing
// angle is one surface. Over a plane, inverse view depth changes evenly from texel to texel in perspective, view depth
// itself in an orthographic picture.

// (s, t): a tap i texels on, of view depth z, lies z (1 + s i) - (own + t i) off the surface. In perspective that is
// measured at the texel's own view depth: both sides times own / (what the surface has there), which spares a division a
// tap. 0, 0 for plain differences.
//
// From the nearer of the two neighbours in depth; a view depth of 0 is nothing. kind: 1 for each of perspective,
// orthographic; inverse_width: of what still counts as the same surface. A neighbour further off is taken only where the
// other lies on the far side of the texel, as on steep planes: a thing one texel wide must not take its background for its
// surface.
fn occlusion_run(before: f32, own: f32, after: f32, kind: vec2f, inverse_width: f32) -> vec2f {
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
