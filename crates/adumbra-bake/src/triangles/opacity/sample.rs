//! Exact samples, several at a time, by the arithmetic of [`adumbra_scene::Texture::alpha`], operation by
//! operation.

use adumbra_scene::Wrap;

use super::OpacityTable;

/// Numbers from this one to its double have no fraction bits.
const WHOLE: f32 = (1_u32 << 23) as f32;

/// Samples that are taken at once.
const N: usize = 8;
/// One bit for each of them.
const BITS: [u32; N] = [1, 2, 4, 8, 16, 32, 64, 128];

/// Samples along one axis: in which cells they are, and how far in.
struct Along {
    cell: [u32; N],
    weight: [f32; N],
}

impl OpacityTable {
    /// Returns which of eight samples are opaque, one bit each.
    #[inline(always)]
    pub(crate) fn opaque_at(&self, [u, v]: [[f32; N]; 2]) -> u8 {
        let (u, v) = (self.along(0, u), self.along(1, v));
        let mut corners = [[0_u8; N]; 4];
        #[expect(clippy::needless_range_loop, reason = "it runs over several arrays at once")]
        for i in 0..N {
            let at = v.cell[i] as usize * self.width + u.cell[i] as usize;
            let (upper, lower) = (self.corners_from(at), self.corners_from(at + self.width));
            [corners[0][i], corners[1][i]] = upper;
            [corners[2][i], corners[3][i]] = lower;
        }
        // Loops of one step each: compilers vectorize these.
        let mut alphas = [[0.0; N]; 4];
        for (alphas, corners) in alphas.iter_mut().zip(&corners) {
            for (alpha, corner) in alphas.iter_mut().zip(corners) {
                *alpha = f32::from(*corner);
            }
        }
        let mut bits = [0_u32; N];
        for i in 0..N {
            let [a, b, c, d] = [alphas[0][i], alphas[1][i], alphas[2][i], alphas[3][i]];
            let mix = |a: f32, b: f32, weight: f32| a + (b - a) * weight;
            let sample = mix(mix(a, b, u.weight[i]), mix(c, d, u.weight[i]), v.weight[i]);
            bits[i] = if sample >= self.opaque_from { BITS[i] } else { 0 };
        }
        bits.into_iter().fold(0, |all, bit| all | bit) as u8
    }

    /// Returns the corner with this number and the next.
    #[inline(always)]
    fn corners_from(&self, at: usize) -> [u8; 2] {
        match self.corners.get(at..at + 2) {
            Some(&[one, next]) => [one, next],
            _ => [u8::MAX; 2],
        }
    }

    #[inline(always)]
    fn along(&self, axis: usize, mut at: [f32; N]) -> Along {
        for c in &mut at {
            *c = if c.abs() < f32::INFINITY { *c } else { 0.0 };
        }
        match self.wrap[axis] {
            Wrap::Repeat => at.iter_mut().for_each(|c| *c -= c.floor()),
            Wrap::Mirror => at.iter_mut().for_each(|c| {
                let along_two = *c - 2.0 * (*c * 0.5).floor();
                *c = if along_two > 1.0 { 2.0 - along_two } else { along_two };
            }),
            Wrap::Clamp => at.iter_mut().for_each(|c| {
                let positive = if *c < 0.0 { 0.0 } else { *c };
                *c = if positive > 1.0 { 1.0 } else { positive };
            }),
        }
        let size = self.size[axis] as f32;
        let mut along = Along { cell: [0; N], weight: [0.0; N] };
        if self.nearest {
            let last = self.size[axis].saturating_sub(1);
            for (cell, at) in along.cell.iter_mut().zip(at) {
                *cell = whole((at * size).floor()).min(last);
            }
        } else {
            #[expect(clippy::needless_range_loop, reason = "it runs over several arrays at once")]
            for i in 0..N {
                let t = at[i] * size - 0.5;
                let low = t.floor();
                along.cell[i] = whole(low + 1.0);
                along.weight[i] = t - low;
            }
        }
        along
    }
}

/// Converts a whole number below 2^23. Unlike a conversion with `as`, it is one vector instruction.
#[inline(always)]
fn whole(number: f32) -> u32 {
    (number + WHOLE).to_bits() & (WHOLE as u32 - 1)
}
