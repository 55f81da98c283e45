//! CPU twin of `passes/occlusion_hbao.wgsl`.

use super::march::{march_texel, rise_over_tangent, towards_eye};
use super::{Center, Pass, dot};

pub(super) fn visibility(pass: &Pass<'_>, c: &Center) -> f32 {
    let o = &pass.params;
    let inverse_radius = 1.0 / c.radius_world;
    let to_eye = towards_eye(pass, c);
    let facing = dot(c.n, to_eye).max(0.0);
    let taps = &pass.taps.taps.0[c.first_tap..c.first_tap + o.tap_count as usize];
    let (mut sum, mut count) = (0.0, 0.0_f32);
    for direction in taps.chunks_exact(o.step_count as usize) {
        let (mut horizon, mut occluded, mut inside) = (o.shape.bias, 0.0, 0.0);
        for tap in direction {
            let texel = march_texel(c, [tap[0], tap[1]], tap[2]);
            let Some(z) = pass.z_at(texel) else { break };
            inside += 1.0;
            if z <= 0.0 {
                continue;
            }
            let w = pass.reach(c, texel, z, inverse_radius);
            let ww = dot(w, w);
            if ww < 1.0 {
                let rise = rise_over_tangent(w, c.n, to_eye, facing);
                if rise > horizon {
                    occluded += (rise - horizon) * (1.0 - ww.powf(o.shape.falloff_exponent));
                    horizon = rise;
                }
            }
        }
        sum += occluded * inside;
        count += inside;
    }
    (1.0 - o.shape.strength * sum / count.max(1.0)).clamp(0.0, 1.0).powf(o.shape.exponent)
}
