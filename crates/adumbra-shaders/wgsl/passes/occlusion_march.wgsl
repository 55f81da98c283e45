// Code shared by estimators that march along screen directions to find horizons. Angles are measured from the
// direction to the eye, so every screen direction defines a slice of space that contains it. A tap: x and y
// are the direction, y up; z is its distance as a fraction of the radius; w is the distance of a tap in the
// opposite direction.

fn towards_eye(c: OcclusionCenter) -> vec3f {
    let ndc = adumbra_occlusion_ndc(occlusion.view, c.texel);
    return -normalize(vec3f(ndc * occlusion.view.half_view_per_depth, 1.0));
}

// Returns the texel at a fraction of the radius along a direction, y up; never the texel of P itself.
fn march_texel(c: OcclusionCenter, along: vec2f, share: f32) -> vec2i {
    let texels = 1.0 + share * max(c.radius_texels - 1.0, 0.0);
    return c.texel + vec2i(round(vec2f(along.x, -along.y) * texels));
}

// Returns how much closer to the direction to the eye the point at w is than P's tangent plane in the same
// slice: the difference of the two cosines, which are the sines of the elevations. The slice is the one that
// contains w itself: a texel's centre is slightly off the requested direction, and at a grazing view the
// tangent in that direction differs. `facing` is the cosine between normal and direction to the eye.
fn rise_over_tangent(w: vec3f, ww: f32, n: vec3f, to_eye: vec3f, facing: f32) -> f32 {
    let a = dot(w, to_eye);
    let h = dot(w, n);
    // Projection onto the tangent plane along the view: t = facing w - h to_eye.
    let t_eye = facing * a - h;
    let tt = ww * facing * facing - 2.0 * facing * h * a + h * h;
    return a * inverseSqrt(ww) - t_eye * inverseSqrt(max(tt, 1e-20));
}
