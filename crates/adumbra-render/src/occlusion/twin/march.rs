//! `passes/occlusion_march.wgsl` on the CPU.

use super::{Center, Pass, dot};

/// Unit.
pub(super) fn towards_eye(pass: &Pass<'_>, c: &Center) -> [f32; 3] {
    let o = &pass.params;
    let across =
        |a: usize| (o.ndc_from_texel[a] * c.texel[a] as f32 + o.ndc_from_texel[a + 2]) * o.half_view[a + 2];
    normalize([across(0), across(1), 1.0]).map(|v| -v)
}

/// The texel at a share of the radius along a direction, y up; never P's own.
pub(super) fn march_texel(c: &Center, along: [f32; 2], share: f32) -> [i32; 2] {
    let texels = 1.0 + share * (c.radius_texels - 1.0).max(0.0);
    let offset = [along[0], -along[1]].map(|v| (v * texels).round_ties_even() as i32);
    [c.texel[0] + offset[0], c.texel[1] + offset[1]]
}

/// Cosine to the eye's direction of what is seen at `w`, less that of the tangent plane in the same slice.
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
