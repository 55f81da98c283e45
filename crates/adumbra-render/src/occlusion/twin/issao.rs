//! `passes/occlusion_issao.wgsl` on the CPU.

use super::{Center, Pass, dot};

pub(super) fn visibility(pass: &Pass<'_>, c: &Center) -> f32 {
    let o = &pass.params;
    let inverse_radius = 1.0 / c.radius_world;
    let bias = o.shape[1] * (c.p[2] * inverse_radius).min(o.shape[2]);
    let (mut sum, mut count) = (0.0, 0.0_f32);
    let mut taken = vec![[0, 0]];
    let taps = taps_at(o.counts, c.radius_texels);
    for i in 0..taps {
        let tap = pass.taps.taps.0[c.first_tap + (i * o.counts[0] / taps) as usize];
        let offset = [tap[0], tap[1]].map(|t| (t * c.radius_texels).round_ties_even() as i32);
        if offset.iter().all(|d| d.abs() <= 2) {
            if taken.contains(&offset) {
                continue;
            }
            taken.push(offset);
        }
        let texel = [c.texel[0] + offset[0], c.texel[1] + offset[1]];
        let Some(z) = pass.z_at(texel) else { continue };
        if z <= 0.0 {
            count += 1.0;
            continue;
        }
        let w = pass.reach(c, texel, z, inverse_radius);
        let ww = dot(w, w);
        if ww < 1.0 {
            count += 1.0;
            sum += term(o.shape[3], o.shape_more, dot(w, c.n), ww, bias);
        }
    }
    let a = (o.shape[0] * sum / count.max(1.0)).clamp(0.0, 1.0);
    1.0 - a.powf(o.shape_more[1])
}

fn term(sigma: f32, [falloff, _, attenuated, _]: [f32; 4], w_n: f32, ww: f32, bias: f32) -> f32 {
    if attenuated == 0.0 {
        return w_n.max(0.0) / ww.max(1e-12).sqrt();
    }
    let term = (w_n - bias).max(0.0) / (ww + sigma);
    if falloff > 0.0 { term * (1.0 - ww).powf(falloff) } else { term }
}

/// Taps that are left where the radius covers so many texels.
fn taps_at(counts: [u32; 4], radius_texels: f32) -> u32 {
    let lost = [16.0, 8.0, 4.0].iter().filter(|&&limit| radius_texels < limit).count() as u32;
    (counts[0] * (4 - lost).max(counts[3]) / 4).max(1)
}
