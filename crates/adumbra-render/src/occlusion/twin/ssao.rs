//! CPU twin of `passes/occlusion_ssao.wgsl`.

use super::{Center, Pass, dot};

pub(super) fn visibility(pass: &Pass<'_>, c: &Center) -> f32 {
    let o = &pass.params;
    let inverse_radius = 1.0 / c.radius_world;
    let (mut sum, mut count) = (0.0, 0.0_f32);
    for &[x, y, z, _] in &pass.taps.taps.0[c.first_tap..c.first_tap + o.tap_count as usize] {
        let tap = [x, y, z];
        let side = if dot(tap, c.n) < 0.0 { -1.0 } else { 1.0 };
        let s: [f32; 3] = std::array::from_fn(|a| c.p[a] + c.radius_world * (side * tap[a]));
        if s[2] <= 0.0 {
            continue;
        }
        let at = pass.texel(s).map(f32::round_ties_even);
        if !(0..2).all(|a| at[a] >= 0.0 && at[a] < o.size[a] as f32) {
            continue;
        }
        count += 1.0;
        let texel = at.map(|c| c as i32);
        let z = pass.z_at(texel).unwrap_or(0.0);
        if z <= 0.0 || (s[2] - z) * inverse_radius <= o.shape.bias {
            continue;
        }
        let w = pass.reach(c, texel, z, inverse_radius);
        if dot(w, c.n) > o.shape.min_rise {
            let near = o.shape.range / w[2].abs().max(o.shape.range);
            sum += near * near * (3.0 - 2.0 * near);
        }
    }
    (1.0 - o.shape.strength * sum / count.max(1.0)).clamp(0.0, 1.0).powf(o.shape.exponent)
}
