//! Comparisons and their means. Twin of core/pcf.wgsl and core/disc.wgsl.

use adumbra_shaders::constants::{HARDWARE_REACH, POISSON_DISC};

use super::maps::Receiver;

/// One layer's depth.
pub(super) struct DepthImage<'a> {
    pub(super) texels: &'a [f32],
    pub(super) size: i64,
}

impl DepthImage<'_> {
    /// The texel's depth. Coordinates are clamped to the border.
    pub(super) fn at(&self, x: i64, y: i64) -> f32 {
        let inside = |c: i64| c.clamp(0, self.size - 1);
        self.texels[(inside(y) * self.size + inside(x)) as usize]
    }

    /// Twin of `adumbra_pcf_nearest`.
    pub(super) fn nearest(&self, r: &Receiver) -> f32 {
        let [x, y] = r.p_texels.map(|c| (c.floor() as i64).clamp(0, self.size - 1));
        let plane = r.plane_depth([x as f32 + 0.5, y as f32 + 0.5]);
        f32::from(u8::from(plane <= self.at(x, y)))
    }

    /// Twin of `adumbra_pcf_hardware`.
    pub(super) fn hardware(&self, r: &Receiver) -> f32 {
        let depth = (r.depth - HARDWARE_REACH * (r.gradient[0].abs() + r.gradient[1].abs())).clamp(0.0, 1.0);
        let p = r.p_texels.map(|c| c - 0.5);
        let [fx, fy] = p.map(|c| c - c.floor());
        let [x, y] = p.map(|c| c.floor() as i64);
        let passed = |dx: i64, dy: i64| f32::from(u8::from(depth <= self.at(x + dx, y + dy)));
        let above = passed(0, 0) * (1.0 - fx) + passed(1, 0) * fx;
        let below = passed(0, 1) * (1.0 - fx) + passed(1, 1) * fx;
        above * (1.0 - fy) + below * fy
    }

    /// Twin of `adumbra_pcf_box`.
    pub(super) fn mean(&self, r: &Receiver, width: u32) -> f32 {
        let half_side = 0.5 * (width as f32 - 1.0);
        let low = r.p_texels.map(|c| c - half_side);
        let high = r.p_texels.map(|c| c + half_side);
        let overlap = |left: f32, a: usize| ((left + 1.0).min(high[a]) - left.max(low[a])).clamp(0.0, 1.0);
        let mut lit = 0.0;
        for dy in 0..width {
            for dx in 0..width {
                let (x, y) = (low[0].floor() + dx as f32, low[1].floor() + dy as f32);
                if r.plane_depth([x + 0.5, y + 0.5]) <= self.at(x as i64, y as i64) {
                    lit += overlap(x, 0) * overlap(y, 1);
                }
            }
        }
        lit / (4.0 * half_side * half_side)
    }

    /// Twin of `adumbra_pcf_disc`.
    pub(super) fn disc(&self, r: &Receiver, radius: f32, taps: u32, turn: [f32; 2]) -> f32 {
        let taps = POISSON_DISC.iter().take(taps as usize);
        let count = taps.len() as f32;
        taps.map(|&tap| self.mean(&r.moved(turned(tap, turn).map(|c| radius * c)), 2)).sum::<f32>() / count
    }
}

/// Twin of `adumbra_disc_tap`.
pub(crate) fn turned(tap: [f32; 2], turn: [f32; 2]) -> [f32; 2] {
    [turn[0] * tap[0] - turn[1] * tap[1], turn[1] * tap[0] + turn[0] * tap[1]]
}

/// Twin of `adumbra_disc_turn`.
pub(crate) fn turn(pixel: [u32; 2]) -> [f32; 2] {
    let angle = std::f32::consts::TAU * noise(pixel);
    [angle.cos(), angle.sin()]
}

/// Twin of `adumbra_interleaved_gradient_noise`.
fn noise([x, y]: [u32; 2]) -> f32 {
    let ramp = x.wrapping_mul(288_237_660).wrapping_add(y.wrapping_mul(25_070_368)) >> 16;
    (ramp.wrapping_mul(54_255) & 0x03ff_ffff) as f32 / 67_108_864.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_matches_the_published_formula() {
        let mut mean = 0.0;
        for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
            let ramp = 0.067_110_56 * f64::from(x) + 0.005_837_15 * f64::from(y);
            let expected = (52.982_918_9 * ramp.fract()).fract();
            let apart = (f64::from(noise([x, y])) - expected).abs();
            assert!(apart.min(1.0 - apart) < 2e-3, "{x} {y}: {apart}");
            mean += expected / 4096.0;
        }
        assert!((mean - 0.5).abs() < 0.02);
    }

    #[test]
    fn disc_taps_are_in_the_unit_circle_and_centred() {
        let mean = |a: usize| POISSON_DISC.iter().map(|p| p[a]).sum::<f32>() / 32.0;
        assert!(mean(0).abs() < 1e-3 && mean(1).abs() < 1e-3);
        for (i, p) in POISSON_DISC.iter().enumerate() {
            assert!(p[0].hypot(p[1]) <= 1.001);
            for q in &POISSON_DISC[..i] {
                assert!((p[0] - q[0]).hypot(p[1] - q[1]) > 0.25);
            }
        }
    }
}
