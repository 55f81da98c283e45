// What estimators share that march along directions on the screen and look for horizons. Angles are those from the direction
// to the eye, so every direction on the screen is a slice of space that holds it.
// A tap: x and y are the direction, y up; z is how far off it is, of the radius; w likewise in the opposite direction.

fn towards_eye(c: OcclusionCenter) -> vec3f {
    let ndc = occlusion.ndc_from_texel.xy * vec2f(c.texel) + occlusion.ndc_from_texel.zw;
    return -normalize(vec3f(ndc * occlusion.half_view.zw, 1.0));
}

// The texel at a share of the radius along a direction, y up; never P's own.
fn march_texel(c: OcclusionCenter, along: vec2f, share: f32) -> vec2i {
    let texels = 1.0 + share * max(c.radius_texels - 1.0, 0.0);
    return c.texel + vec2i(round(vec2f(along.x, -along.y) * texels));
}

// How much nearer to the eye's direction what is seen at w lies than P's tangent plane in the same slice: the difference of
// the two cosines, or sines of elevation. The slice is the one that w itself lies in: a texel's centre is a little off the
// direction that was asked for, and at a grazing view the tangent of that one is another. facing is the cosine between
// normal and eye.
fn rise_over_tangent(w: vec3f, ww: f32, n: vec3f, to_eye: vec3f, facing: f32) -> f32 {
    let a = dot(w, to_eye);
    let h = dot(w, n);
    // Down to the tangent plane along the view: t = facing w - h to_eye.
    let t_eye = facing * a - h;
    let tt = ww * facing * facing - 2.0 * facing * h * a + h * h;
    return a * inverseSqrt(ww) - t_eye * inverseSqrt(max(tt, 1e-20));
}
