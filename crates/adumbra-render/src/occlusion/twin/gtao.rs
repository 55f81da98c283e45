//! CPU twin of `passes/occlusion_gtao.wgsl`.

use super::march::{march_texel, normalize, rise_over_tangent, towards_eye};
use super::{Center, Pass, dot};

pub(super) fn visibility(pass: &Pass<'_>, c: &Center) -> f32 {
    let o = &pass.params;
    let inverse_radius = 1.0 / c.radius_world;
    let to_eye = towards_eye(pass, c);
    let facing = dot(c.n, to_eye).max(0.0);
    let [count, steps] = [o.tap_count, o.step_count];
    let sides = (count / steps).min(2);
    let taps = &pass.taps.taps.0[c.first_tap..c.first_tap + (count / sides) as usize];
    let (mut seen, mut open) = (0.0, 0.0);
    for slice in taps.chunks_exact(steps as usize) {
        let along = [slice[0][0], slice[0][1], 0.0];
        let to = dot(along, to_eye);
        let across = normalize([0, 1, 2].map(|a| along[a] - to_eye[a] * to));
        let n_across = dot(c.n, across);
        let length = (facing * facing + n_across * n_across).max(1e-12).sqrt();
        for sign in [1.0, -1.0].into_iter().take(sides as usize) {
            let (mut rise, mut inside) = (0.0_f32, 0.0);
            for tap in slice {
                let share = if sign < 0.0 { tap[3] } else { tap[2] };
                let texel = march_texel(c, [sign * tap[0], sign * tap[1]], share);
                let Some(z) = pass.z_at(texel) else { break };
                inside += 1.0;
                if z <= 0.0 {
                    continue;
                }
                let w = pass.reach(c, texel, z, inverse_radius);
                let stretched = [w[0], w[1], w[2] * o.shape.depth_stretch];
                let far = dot(stretched, stretched).sqrt();
                if far < 1.0 {
                    let weight = ((1.0 - far) * o.shape.falloff_slope).min(1.0);
                    rise = rise.max(weight * rise_over_tangent(w, c.n, to_eye, facing));
                }
            }
            let n_slice = [facing, sign * n_across];
            let cos_tangent = -n_slice[1] / length;
            open += inside * arc(n_slice, cos_tangent);
            seen += inside * arc(n_slice, (cos_tangent + rise).min(1.0));
        }
    }
    let visibility = if open > 1e-6 { seen / open } else { 1.0 };
    visibility.clamp(0.0, 1.0).powf(o.shape.exponent)
}

fn acos_near(x: f32) -> f32 {
    let y = x.abs();
    let angle =
        (1.0 - y).max(0.0).sqrt() * (((-0.018_729_3 * y + 0.074_261) * y - 0.212_114_4) * y + 1.570_728_8);
    if x < 0.0 { std::f32::consts::PI - angle } else { angle }
}

fn arc(n_slice: [f32; 2], cos_h: f32) -> f32 {
    let sin_h_2 = (1.0 - cos_h * cos_h).max(0.0);
    0.5 * (n_slice[0] * sin_h_2 + n_slice[1] * (acos_near(cos_h) - sin_h_2.sqrt() * cos_h))
}
