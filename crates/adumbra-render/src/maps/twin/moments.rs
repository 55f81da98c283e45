//! Statistics of depth. Twin of core/moments.wgsl, vsm.wgsl, evsm.wgsl and msm.wgsl.

use adumbra_shaders::constants::MOMENT_BIAS;
use adumbra_shaders::layout::{MapLayer, MapParams, MomentParams};

use super::channels;
use crate::error::Result;
use crate::gpu::Gpu;
use crate::maps::params::MomentKind;
use crate::readback::read_floats;

/// Moments of all layers.
pub(super) struct MomentImage {
    /// By layer, then by mip level. Only the first level if look-ups use no other.
    levels: Vec<Vec<Vec<f32>>>,
    size: i64,
    channels: usize,
}

impl MomentImage {
    pub(super) fn read(
        gpu: &Gpu,
        texture: &wgpu::Texture,
        layers: u32,
        kind: MomentKind,
        mips: bool,
    ) -> Result<Self> {
        let count = if mips { texture.mip_level_count() } else { 1 };
        let layer = |l| (0..count).map(|m| read_floats(gpu, texture, m, l)).collect::<Result<_>>();
        let levels = (0..layers).map(layer).collect::<Result<_>>()?;
        Ok(Self { levels, size: i64::from(texture.width()), channels: channels(kind) })
    }

    pub(super) fn texel(&self, layer: usize, level: usize, x: i64, y: i64) -> [f32; 4] {
        let side = self.size >> level;
        let inside = |c: i64| c.clamp(0, side - 1);
        let at = (inside(y) * side + inside(x)) as usize * self.channels;
        let mut m = [0.0; 4];
        m[..self.channels].copy_from_slice(&self.levels[layer][level][at..at + self.channels]);
        m
    }

    fn bilinear(&self, layer: usize, level: usize, p_texels: [f32; 2]) -> [f32; 4] {
        let shrink = 1.0 / (1_u32 << level) as f32;
        let p = p_texels.map(|c| c * shrink - 0.5);
        let [fx, fy] = p.map(|c| c - c.floor());
        let [x, y] = p.map(|c| c.floor() as i64);
        let texel = |dx, dy| self.texel(layer, level, x + dx, y + dy);
        mix4(mix4(texel(0, 0), texel(1, 0), fx), mix4(texel(0, 1), texel(1, 1), fx), fy)
    }

    /// Samples with trilinear filtering.
    pub(super) fn sample(&self, layer: usize, p_texels: [f32; 2], level: f32) -> [f32; 4] {
        let last = self.levels[layer].len() - 1;
        let low = (level as usize).min(last);
        let part = if low == last { 0.0 } else { level - low as f32 };
        let near = self.bilinear(layer, low, p_texels);
        if part == 0.0 { near } else { mix4(near, self.bilinear(layer, low + 1, p_texels), part) }
    }
}

fn mix4(a: [f32; 4], b: [f32; 4], t: f32) -> [f32; 4] {
    std::array::from_fn(|c| a[c] * (1.0 - t) + b[c] * t)
}

/// Twin of `adumbra_moments_level`.
pub(super) fn level(params: &MapParams, layer: &MapLayer, view_depth: f32) -> f32 {
    let pixel_world = params.pixel_world + params.pixel_world_per_depth * view_depth.max(0.0);
    (pixel_world / layer.texel_world).max(1.0).log2().clamp(0.0, params.mip_levels - 1.0)
}

/// Twin of `adumbra_moments_of`.
pub(super) fn from_depth(kind: MomentKind, depth: f32, exponents: [f32; 2]) -> [f32; 4] {
    match kind {
        MomentKind::Variance => {
            let t = depth - 0.5;
            [t, t * t, 0.0, 0.0]
        }
        MomentKind::ExponentialVariance => {
            let [p, n] = warp(depth, exponents);
            [p, p * p, n, n * n]
        }
        MomentKind::FourMoments => {
            let t = 2.0 * depth - 1.0;
            let t2 = t * t;
            [t, t2, t2 * t, t2 * t2]
        }
    }
}

/// Twin of `adumbra_moments_visibility`.
pub(super) fn visibility(
    kind: MomentKind,
    m: [f32; 4],
    depth: f32,
    deviation: f32,
    params: &MomentParams,
) -> f32 {
    let bleed = params.bleed;
    match kind {
        MomentKind::Variance => chebyshev([m[0], m[1]], depth - 0.5, deviation * deviation, bleed),
        MomentKind::ExponentialVariance => {
            let exponents = params.exponents;
            let w = warp(depth, exponents);
            let bound = |a: usize| {
                let stretched = 2.0 * deviation * exponents[a] * w[a];
                chebyshev([m[2 * a], m[2 * a + 1]], w[a], stretched * stretched, bleed)
            };
            bound(0).min(bound(1))
        }
        MomentKind::FourMoments => four_moments(m, depth, deviation, bleed),
    }
}

fn warp(depth: f32, exponents: [f32; 2]) -> [f32; 2] {
    let t = 2.0 * depth - 1.0;
    [(exponents[0] * t).exp(), -(-exponents[1] * t).exp()]
}

fn chebyshev(m: [f32; 2], t: f32, min_variance: f32, bleed: f32) -> f32 {
    if t <= m[0] {
        return 1.0;
    }
    let variance = (m[1] - m[0] * m[0]).max(min_variance.max(1e-12));
    let behind = t - m[0];
    cut(variance / (variance + behind * behind), bleed)
}

fn cut(bound: f32, bleed: f32) -> f32 {
    ((bound - bleed) / (1.0 - bleed)).clamp(0.0, 1.0)
}

fn four_moments(m: [f32; 4], depth: f32, deviation: f32, bleed: f32) -> f32 {
    let t = 2.0 * depth - 1.0;
    let m = mix4(m, [0.0, 0.375, 0.0, 0.375], MOMENT_BIAS);
    let s = 4.0 * deviation * deviation;
    let b = [m[0], m[1] + s, m[2] + 3.0 * s * m[0], m[3] + 6.0 * s * m[1] + 3.0 * s * s];
    let d1 = b[1] - b[0] * b[0];
    let l21 = (b[2] - b[0] * b[1]) / d1;
    let d2 = (b[3] - b[1] * b[1] - l21 * l21 * d1).max(1e-12);
    let y1 = t - b[0];
    let y2 = t * t - b[1] - l21 * y1;
    let q2 = y2 / d2;
    let q1 = y1 / d1 - l21 * q2;
    let q0 = 1.0 - b[0] * q1 - b[1] * q2;
    let p = q1 / q2;
    let root = (0.25 * p * p - q0 / q2).max(0.0).sqrt();
    let (z1, z2) = (-0.5 * p - root, -0.5 * p + root);
    let weight = |a: f32, other: f32| (b[1] - b[0] * (t + other) + t * other) / ((a - t) * (a - other));
    let mut shadow = 0.0;
    if z1 < t {
        shadow += weight(z1, z2);
    }
    if z2 < t {
        shadow += weight(z2, z1);
    }
    cut(1.0 - shadow.clamp(0.0, 1.0), bleed)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARAMS: MomentParams =
        MomentParams { exponents: [40.0, 5.0], min_deviation_texels: 0.0, bleed: 0.0 };

    #[test]
    fn moment_bounds_are_exact_for_two_depths() {
        // A share of 0.3 is at depth 0.7 and the rest at 0.2, so a receiver at 0.7 is 0.3 lit.
        for kind in [MomentKind::Variance, MomentKind::ExponentialVariance, MomentKind::FourMoments] {
            let m =
                mix4(from_depth(kind, 0.2, PARAMS.exponents), from_depth(kind, 0.7, PARAMS.exponents), 0.3);
            let lit = visibility(kind, m, 0.7, 1e-4, &PARAMS);
            assert!((lit - 0.3).abs() < 0.02, "{kind:?} {lit}");
            assert!(visibility(kind, m, 0.15, 1e-4, &PARAMS) > 0.95, "{kind:?}");
        }
    }

    #[test]
    fn receiver_at_the_mean_is_lit_whatever_the_variance() {
        assert_eq!(chebyshev([0.3, 0.09], 0.3, 0.0, 0.0), 1.0);
        assert!(chebyshev([0.3, 0.09], 0.4, 0.0, 0.0) < 1e-6);
    }

    #[test]
    fn cut_removes_the_tail() {
        assert_eq!(cut(0.2, 0.2), 0.0);
        assert_eq!(cut(1.0, 0.2), 1.0);
        assert!((cut(0.6, 0.2) - 0.5).abs() < 1e-6);
    }
}
