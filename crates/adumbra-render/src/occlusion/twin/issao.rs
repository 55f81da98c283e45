//! `passes/occlusion_issao.wgsl` on the CPU.

use super::{Center, Pass, dot};

pub(super) fn visibility(pass: &Pass<'_>, c: &Center) -> f32 {
    let o = &pass.params;
    let [strength, psi, z_cap, sigma] = o.shape;
    let [exponent, attenuated, ..] = o.shape_more;
    let inverse_radius = 1.0 / c.radius_world;
    let bias = psi * (c.p[2] * inverse_radius).min(z_cap);
    let (mut sum, mut count) = (0.0, 0.0_f32);
    let mut taken = vec![[0, 0]];
    for tap in &pass.taps.taps.0[c.first_tap..c.first_tap + taps_at(o.counts, c.radius_texels)] {
        let offset = [tap[0], tap[1]].map(|t| (t * c.radius_texels).round_ties_even() as i32);
        if offset.iter().all(|d| d.abs() <= 2) {
            if taken.contains(&offset) {
                continue;
            }
            taken.push(offset);
        }
        let texel = [c.texel[0] + offset[0], c.texel[1] + offset[1]];
        let Some(z) = pass.z_at(texel) else { continue };
        count += 1.0;
        if z <= 0.0 {
            continue;
        }
        let s = pass.point(texel, z);
        let w: [f32; 3] = std::array::from_fn(|a| (s[a] - c.p[a]) * inverse_radius);
        let ww = dot(w, w);
        if ww < 1.0 {
            let height = (dot(w, c.n) - bias).max(0.0);
            sum += if attenuated == 0.0 {
                height / (ww + sigma).sqrt()
            } else if exponent > 0.0 {
                height / (ww + sigma) * (1.0 - ww).powf(exponent)
            } else {
                height / (ww + sigma)
            };
        }
    }
    1.0 - (strength * sum / count.max(1.0)).clamp(0.0, 1.0)
}

/// Taps that are left where the radius covers so many texels.
fn taps_at(counts: [u32; 4], radius_texels: f32) -> usize {
    let level = [16.0, 8.0, 4.0].iter().filter(|&&limit| radius_texels < limit).count() as u32;
    let parts = (4 - level).max(counts[3]);
    (counts[0] * parts / 4).max(1) as usize
}
