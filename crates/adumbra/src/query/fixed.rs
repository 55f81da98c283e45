//! Receivers in fixed point. From here on a look-up uses only integers, so that the CPU, the GPU and any
//! other reader agree on every tap. The rule is in `spec/adumbra-file.md`, "Look-up bias and filters".
//!
//! | number | fraction bits | minimum | maximum |
//! |---|---|---|---|
//! | grid position p | 12 | −4096 voxels | side + 4096 voxels: below 2^31 for sides of at most [`MAX_FIXED_SIDE`] |
//! | gradient g | 8 | −30,720 | 30,720 (a slope of 120) |
//! | centre of a tap − p | 12 | −8.5 voxels | 8.5 voxels: ±34,816 |
//! | g · (centre − p), one axis | 20 | −1,069,547,520 | 1,069,547,520 |
//! | sum s of both axes | 20 | −2,139,095,040 | 2,139,095,040: within 2^31 |
//! | s >> 8, the plane's depth offset | 12 | −2040 voxels | 2040 voxels: less than half the margin |
//!
//! Worked value: g = (128, 0) is a slope of 1/2, and p = (30720, 18432, 82944) is (7.5, 4.5, 20.25). The
//! centre of the tap x = 6 is at 26624. So s = 128 · (−4096) = −524,288, and the depth is 82944 − 2048 =
//! 80896 = 19.75, which is in layer 19.

use crate::query::Receiver;
use crate::settings::MAX_PLANE_SLOPE;

/// Number of fraction bits of a grid position.
pub const FIXED_BITS: u32 = 12;
/// One voxel in units of a fixed-point grid position.
pub const FIXED_ONE: i32 = 1 << FIXED_BITS;
/// Number of fraction bits of a gradient.
pub const GRADIENT_BITS: u32 = 8;
/// A slope of 1 in units of a fixed-point gradient.
pub const GRADIENT_ONE: i32 = 1 << GRADIENT_BITS;
/// Positions are clamped to this many voxels beyond the grid. All taps of a point that far away are outside
/// the grid, however steep the plane.
pub const MARGIN_VOXELS: i32 = 4096;
/// Largest number of voxels along a side of a grid for which positions, and the depths computed from them,
/// fit 32 bits.
pub const MAX_FIXED_SIDE: u32 = (1 << 19) - (1 << 13);

/// Largest absolute value of a fixed-point gradient.
pub const MAX_GRADIENT: i32 = (MAX_PLANE_SLOPE * GRADIENT_ONE as f64) as i32;

/// A [`Receiver`] in fixed point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FixedReceiver {
    /// Grid position after the bias, [`FIXED_ONE`] per voxel. It fits 32 bits if the grid's sides are at most
    /// [`MAX_FIXED_SIDE`].
    pub p_fixed: [i64; 3],
    /// dz/dx and dz/dy, [`GRADIENT_ONE`] for a slope of 1.
    pub gradient: [i32; 2],
}

impl FixedReceiver {
    /// Converts a receiver to fixed point. Positions are rounded down, gradients to the nearest value.
    ///
    /// A point far outside a grid of `size` voxels is clamped to [`MARGIN_VOXELS`] beyond it. A point that is
    /// not finite is placed before the grid, where everything is lit.
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

    /// Returns the texel that contains the point. It may be outside the grid.
    pub fn texel(&self) -> [i64; 2] {
        [0, 1].map(|a| self.p_fixed[a] >> FIXED_BITS)
    }

    /// Returns the layer in which the receiver's plane crosses the centre of a texel: negative before the
    /// grid, and not limited behind it.
    pub fn layer(&self, texel: [i64; 2]) -> i64 {
        self.depth(texel) >> (FIXED_BITS + GRADIENT_BITS)
    }

    /// Returns the depth of the receiver's plane at the centre of a texel, in 2^-20 voxels. The layer index
    /// is in the bits above [`FIXED_BITS`] + [`GRADIENT_BITS`]. It is negative before the grid.
    pub fn depth(&self, [x, y]: [i64; 2]) -> i64 {
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
        // The farthest taps of a 17 × 17 filter, along both axes.
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
