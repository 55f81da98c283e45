//! CPU twin of `passes/occlusion_march.wgsl`.

use super::{Center, Pass, dot, ndc};

/// Unit vector towards the eye.
pub(super) fn towards_eye(pass: &Pass<'_>, c: &Center) -> [f32; 3] {
    let view = &pass.params.view;
    let ndc = ndc(view, c.texel);
    let [x, y] = [0, 1].map(|a| ndc[a] * view.half_view_per_depth[a]);
    normalize([x, y, 1.0]).map(|v| -v)
}

/// The texel at a share of the radius along a direction, y up. Never the centre's own texel.
pub(super) fn march_texel(c: &Center, along: [f32; 2], share: f32) -> [i32; 2] {
    let texels = 1.0 + share * (c.radius_texels - 1.0).max(0.0);
    let offset = [along[0], -along[1]].map(|v| (v * texels).round_ties_even() as i32);
    [c.texel[0] + offset[0], c.texel[1] + offset[1]]
}

/// Cosine between the direction of `w` and the eye's, minus that of the tangent plane in the same slice.
pub(super) fn rise_over_tangent(w: [f32; 3], n: [f32; 3], to_eye: [f32; 3], facing: f32) -> f32 {
    let ww = dot(w, w);
    let (a, h) = (dot(w, to_eye), dot(w, n));
    let t_eye = facing * a - h;
    let tt = ww * facing * facing - 2.0 * facing * h * a + h * h;
    a / ww.sqrt() - t_eye / tt.max(1e-20).sqrt()
}

pub(super) fn normalize(v: [f32; 3]) -> [f32; 3] {
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}
