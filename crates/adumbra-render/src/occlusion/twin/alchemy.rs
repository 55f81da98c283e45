//! CPU twin of `passes/occlusion_alchemy.wgsl`.

use super::{Center, Pass, dot};

pub(super) fn visibility(pass: &Pass<'_>, c: &Center) -> f32 {
    let o = &pass.params;
    let inverse_radius = 1.0 / c.radius_world;
    let bias = o.shape.bias * c.p[2] * inverse_radius;
    let (mut sum, mut count) = (0.0, 0.0_f32);
    for tap in &pass.taps.taps.0[c.first_tap..c.first_tap + o.tap_count as usize] {
        let texel = [0, 1].map(|a| c.texel[a] + (tap[a] * c.radius_texels).round_ties_even() as i32);
        let Some(z) = pass.z_at(texel) else { continue };
        count += 1.0;
        if z > 0.0 {
            let w = pass.reach(c, texel, z, inverse_radius);
            sum += (dot(w, c.n) - bias).max(0.0) / (dot(w, w) + o.shape.epsilon);
        }
    }
    (1.0 - o.shape.strength * sum / count.max(1.0)).clamp(0.0, 1.0).powf(o.shape.exponent)
}
