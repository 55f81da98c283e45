//! Penumbrae from switch depths, on the CPU. Twin of core/depths_soft.wgsl.

use adumbra::LightGrid;
use adumbra::layout::depths::DepthTree;
use adumbra::query::{FIXED_BITS, FIXED_ONE, FixedReceiver, GRADIENT_BITS};
use adumbra_shaders::constants::POISSON_DISC;

use crate::maps::twin::{turn, turned};

/// A look-up of the penumbrae of a sun of a given size.
pub struct SoftTwin<'d> {
    depths: &'d DepthTree,
    /// Growth of the radius of the sun's cone, texels per voxel of depth.
    cone: f32,
    max_radius: f32,
    /// From the disc across the light to the grid.
    ellipse: [[f32; 2]; 2],
}

impl<'d> SoftTwin<'d> {
    /// Creates the look-up for a sun of `sun_degrees`. A penumbra's radius, from its middle to its edge, is
    /// at most `max_radius_texels`.
    pub fn new(grid: &LightGrid, depths: &'d DepthTree, sun_degrees: f64, max_radius_texels: f64) -> Self {
        let ellipse = grid.circle_across_light().map(|row| row.map(|c| c as f32));
        let cone = grid.cone_texels_per_voxel(sun_degrees) as f32;
        Self { depths, cone, max_radius: max_radius_texels as f32, ellipse }
    }

    /// Visible share of the sun's disc at a receiver, 1 = all of it. `pixel` determines the rotation of the
    /// taps.
    pub fn visibility(&self, r: &FixedReceiver, pixel: [u32; 2]) -> f32 {
        let turn = turn(pixel);
        let Some(distance) = self.blocker_distance(r, turn) else { return 1.0 };
        let radius = (self.cone * distance).clamp(0.5, self.max_radius);
        let taps = POISSON_DISC.iter().map(|&tap| {
            let offset = turned(tap, turn).map(|c| radius * c);
            self.bilinear(r, self.on_disc(r, offset))
        });
        taps.sum::<f32>() / POISSON_DISC.len() as f32
    }

    /// Twin of `adumbra_depths_disc`.
    fn on_disc(&self, r: &FixedReceiver, offset: [f32; 2]) -> [i64; 2] {
        [0, 1].map(|a| {
            let [x, y] = self.ellipse[a];
            let texels = x * offset[0] + y * offset[1];
            r.p_fixed[a] + (texels * FIXED_ONE as f32).floor() as i64
        })
    }

    /// Twin of `adumbra_depths_blocker_distance`.
    fn blocker_distance(&self, r: &FixedReceiver, turn: [f32; 2]) -> Option<f32> {
        let search = (self.cone * r.p_fixed[2] as f32 / FIXED_ONE as f32).clamp(1.0, self.max_radius);
        let length = |v: [f32; 2]| (v[0] * v[0] + v[1] * v[1]).sqrt();
        let (mut sum, mut count) = (0.0, 0.0);
        for &tap in &POISSON_DISC {
            let tap = turned(tap, turn);
            let offset = tap.map(|c| search * length(tap) * c);
            let Some(fixed) = self.blocker(r, self.on_disc(r, offset).map(|c| c >> FIXED_BITS)) else {
                continue;
            };
            let distance = fixed as f32 / FIXED_ONE as f32;
            if length(offset) <= (self.cone * distance).max(1.0) {
                sum += distance;
                count += 1.0;
            }
        }
        (count > 0.0).then(|| sum / count)
    }

    /// Twin of `adumbra_depths_blocker`.
    fn blocker(&self, r: &FixedReceiver, texel: [i64; 2]) -> Option<i64> {
        let one = i64::from(FIXED_ONE);
        let along: i64 =
            (0..2).map(|a| i64::from(r.gradient[a]) * (texel[a] * one + one / 2 - r.p_fixed[a])).sum();
        let layer = (r.p_fixed[2] + (along >> GRADIENT_BITS)).min(r.p_fixed[2]) >> FIXED_BITS;
        let size = self.depths.size().map(i64::from);
        if (0..2).any(|a| texel[a] < 0 || texel[a] >= size[a]) || layer < 0 {
            return None;
        }
        let value = i64::from(self.depths.value(texel[0] as u32, texel[1] as u32));
        (layer.min(size[2] - 1) >= value).then(|| (r.p_fixed[2] - value * one).max(0))
    }

    /// Twin of `adumbra_depths_bilinear`.
    fn bilinear(&self, r: &FixedReceiver, p_fixed: [i64; 2]) -> f32 {
        let from = p_fixed.map(|c| c - i64::from(FIXED_ONE / 2));
        let corner = from.map(|c| c >> FIXED_BITS);
        let [u, v] = from.map(|c| (c & i64::from(FIXED_ONE - 1)) as f32 / FIXED_ONE as f32);
        let lit = |x, y| f32::from(u8::from(self.blocker(r, [corner[0] + x, corner[1] + y]).is_none()));
        let row = |y| lit(0, y) * (1.0 - u) + lit(1, y) * u;
        row(0) * (1.0 - v) + row(1) * v
    }
}
