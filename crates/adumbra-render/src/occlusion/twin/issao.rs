//! CPU twin of `passes/occlusion_issao.wgsl`.

use super::{Center, Pass, dot};
use crate::occlusion::settings::Term;

pub(super) fn visibility(pass: &Pass<'_>, c: &Center, term: Term) -> f32 {
    let o = &pass.params;
    let inverse_radius = 1.0 / c.radius_world;
    let bias = o.shape.bias * (c.p[2] * inverse_radius).min(o.shape.max_bias_depth);
    let (mut sum, mut count) = (0.0, 0.0_f32);
    let mut before = [0, 0];
    let taps = taps_at([o.tap_count, o.min_quarters], c.radius_texels);
    let stride = (o.tap_count << 16) / taps;
    for i in 0..taps {
        let tap = pass.taps.taps.0[c.first_tap + ((i * stride) >> 16) as usize];
        let offset = [tap[0], tap[1]].map(|t| (t * c.radius_texels).round_ties_even() as i32);
        let texel = [c.texel[0] + offset[0], c.texel[1] + offset[1]];
        let is_new = offset != before;
        before = offset;
        let Some(z) = pass.z_at(texel).filter(|_| is_new) else { continue };
        if z <= 0.0 {
            count += 1.0;
            continue;
        }
        let mut w = pass.reach(c, texel, z, inverse_radius);
        let ww = dot(w, w);
        if ww >= 1.0 {
            if w[2] > 0.0 {
                count += 1.0;
                continue;
            }
            if w[2] == 0.0 || o.shape.hides_from_outside == 0 {
                continue;
            }
            w[2] = -(1.0 - w[0] * w[0] - w[1] * w[1]).max(0.0).sqrt();
        }
        count += 1.0;
        let (w_n, ww, over) = (dot(w, c.n), ww.min(1.0), ww.max(1.0).sqrt());
        sum += match term {
            Term::Attenuated => (w_n - bias).max(0.0) / (ww + o.shape.epsilon),
            Term::Falloff => {
                (w_n - bias).max(0.0) / (ww + o.shape.epsilon) * (1.0 - ww).powf(o.shape.falloff_exponent)
            }
            Term::Bare => w_n.max(0.0) / ww.max(1e-12).sqrt(),
        } / over;
    }
    let a = (o.shape.strength * sum / count.max(1.0)).clamp(0.0, 1.0);
    (1.0 - a).powf(o.shape.exponent)
}

/// Number of taps taken if the radius covers `radius_texels`.
fn taps_at([tap_count, min_quarters]: [u32; 2], radius_texels: f32) -> u32 {
    let lost = [16.0, 8.0, 4.0].iter().filter(|&&limit| radius_texels < limit).count() as u32;
    (tap_count * (4 - lost).max(min_quarters) / 4).max(1)
}
