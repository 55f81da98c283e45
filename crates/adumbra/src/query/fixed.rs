//! Receivers in fixed point: from here on a look-up is whole numbers, so that CPU, GPU and any other reader agree to the last
//! tap. `spec/adumbra-file.md`, "Bias and filters", has the rule.
//!
//! | number | bits behind the point | from | to |
//! |---|---|---|---|
//! | grid position p | 12 | −4096 voxels | side + 4096 voxels: below 2^31 where a side has at most [`MAX_FIXED_SIDE`] voxels |
//! | gradient g | 8 | −30,720 | 30,720 (120) |
//! | centre of a tap − p | 12 | −8.5 voxels | 8.5 voxels: ±34,816 |
//! | g · (centre − p), one axis | 20 | −1,069,547,520 | 1,069,547,520 |
//! | sum s of both axes | 20 | −2,139,095,040 | 2,139,095,040: within 2^31 |
//! | s >> 8, what the plane adds | 12 | −2040 voxels | 2040 voxels: less than half the margin |
//!
//! Worked value: g = (128, 0) is a slope of 1/2, p = (30720, 18432, 82944) is (7.5, 4.5, 20.25). The tap x = 6 has its centre at
//! 26624: s = 128 · (−4096) = −524,288; depth = 82944 − 2048 = 80896 = 19.75, layer 19.

use super::Receiver;
use crate::settings::MAX_PLANE_SLOPE;

/// Bits behind the point of a grid position.
pub const FIXED_BITS: u32 = 12;
/// A voxel in grid positions.
pub const FIXED_ONE: i32 = 1 << FIXED_BITS;
/// Bits behind the point of a gradient.
pub const GRADIENT_BITS: u32 = 8;
/// Slope 1 in gradients.
pub const GRADIENT_ONE: i32 = 1 << GRADIENT_BITS;
/// Voxels beyond the grid that positions are clamped to: every tap there is outside, however steep the plane.
pub const MARGIN_VOXELS: i32 = 4096;
/// Most voxels along a side of a grid whose positions, and the depths made of them, fit 32 bits.
pub const MAX_FIXED_SIDE: u32 = (1 << 19) - (1 << 13);

/// Largest number of a gradient.
pub const MAX_GRADIENT: i32 = (MAX_PLANE_SLOPE * GRADIENT_ONE as f64) as i32;

/// A [`Receiver`] in fixed point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FixedReceiver {
    /// Grid position after the bias, [`FIXED_ONE`] to a voxel; fits 32 bits where the grid's sides are at most
    /// [`MAX_FIXED_SIDE`].
    pub p_fixed: [i64; 3],
    /// dz/dx and dz/dy, [`GRADIENT_ONE`] to a slope of 1.
    pub gradient: [i32; 2],
}

impl FixedReceiver {
    /// Positions rounded down, gradients to the nearest. A point far beyond a grid of `size` voxels stands
    /// [`MARGIN_VOXELS`] beyond it; one that is not finite, before it, where everything is lit.
    pub fn new(r: &Receiver, size: [u32; 3]) -> Self {
        let finite = r.p_grid.iter().all(|c| c.is_finite());
        let p_fixed = std::array::from_fn(|a| {
            let far = i64::from(size[a]) + i64::from(MARGIN_VOXELS);
            let [low, high] = [-i64::from(MARGIN_VOXELS), far].map(|voxels| voxels << FIXED_BITS);
            let fixed = (r.p_grid[a] * f64::from(FIXED_ONE)).floor() as i64;
            if finite { fixed.clamp(low, high) } else { low }
        });
        let gradient = r.gradient.map(|g| {
            let fixed = (g * f64::from(GRADIENT_ONE) + 0.5).floor() as i32;
            fixed.clamp(-MAX_GRADIENT, MAX_GRADIENT)
        });
        Self { p_fixed, gradient }
    }

    /// The texel that the point lies in.
    pub(super) fn texel(&self) -> [i64; 2] {
        [0, 1].map(|a| self.p_fixed[a] >> FIXED_BITS)
    }

    /// Depth of the receiver's plane at the centre of a texel, in 2^-20 voxels: its layer's number stands above [`FIXED_BITS`] +
    /// [`GRADIENT_BITS`], and is below 0 before the grid.
    pub(super) fn depth(&self, [x, y]: [i64; 2]) -> i64 {
        let half = i64::from(FIXED_ONE / 2);
        let along = |a: usize, texel: i64| {
            i64::from(self.gradient[a]) * ((texel << FIXED_BITS) + half - self.p_fixed[a])
        };
        (self.p_fixed[2] << GRADIENT_BITS) + along(0, x) + along(1, y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_receiver_worked_values() {
        let r = Receiver { p_grid: [7.5, 4.5, 20.25], gradient: [0.5, 0.0] };
        let fixed = FixedReceiver::new(&r, [64; 3]);
        assert_eq!(fixed, FixedReceiver { p_fixed: [30720, 18432, 82944], gradient: [128, 0] });
        assert_eq!(fixed.texel(), [7, 4]);
        assert_eq!([6, 7, 8].map(|x| fixed.depth([x, 3]) >> 20), [19, 20, 20]);
    }

    #[test]
    fn fixed_receiver_rounds_down_and_stays_near_the_grid() {
        let fixed =
            |p_grid, gradient| FixedReceiver::new(&Receiver { p_grid, gradient }, [8, 16, MAX_FIXED_SIDE]);
        assert_eq!(fixed([-0.000_01, 2.999_999, 0.5], [0.0; 2]).p_fixed, [-1, 12287, 2048]);
        assert_eq!(fixed([0.0; 3], [121.0, -200.0]).gradient, [30720, -30720]);
        assert_eq!(fixed([0.0; 3], [0.003, f64::NAN]).gradient, [1, 0]);
        let far = fixed([1e30, -1e30, 1e30], [0.0; 2]).p_fixed;
        assert_eq!(far, [4104 << 12, -4096 << 12, (i64::from(MAX_FIXED_SIDE) + 4096) << 12]);
        assert!(far[2] + (2040 << 12) <= i64::from(i32::MAX));
        assert_eq!(fixed([1.0, f64::INFINITY, 1.0], [0.0; 2]).p_fixed, [-4096 << 12; 3]);
    }

    #[test]
    fn fixed_depths_never_leave_the_documented_range() {
        // The farthest that taps of a 17 × 17 filter lie, along both axes.
        let depths = [-MAX_GRADIENT, MAX_GRADIENT].into_iter().flat_map(|g| {
            [-8, 8].into_iter().flat_map(move |tap| {
                [0, i64::from(FIXED_ONE) - 1].map(|fraction| {
                    let r = FixedReceiver { p_fixed: [fraction, fraction, 0], gradient: [g, g] };
                    r.depth([tap, tap])
                })
            })
        });
        let farthest = depths.map(i64::abs).max();
        assert_eq!(farthest, Some(2_139_095_040));
        assert!(
            farthest.is_some_and(|depth| depth >> GRADIENT_BITS < i64::from(MARGIN_VOXELS / 2) << FIXED_BITS)
        );
    }
}
