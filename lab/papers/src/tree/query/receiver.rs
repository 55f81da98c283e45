//! A point in the cube of a tree in fixed point. From here on a look-up with its kernel uses integers, so
//! that CPU and GPU agree to the last tap. The rule is in `spec/adumbra-tree.md`, "Look-up with a kernel".
//!
//! | number | fractional bits | min | max |
//! |---|---|---|---|
//! | position p, voxels | 12 | 0 | 2^27 − 1: a side has at most 2^15 voxels |
//! | normal n | 10 | −1024 | 1024 |
//! | height h above the receiver's plane, cells | 10 | −8192 | 8192 |
//! | centre of the point's cell − p, cells | 12 | −2047 | 2048 |
//! | n · (centre − p) + 4096 h | 22 | −2^26 | 2^26 |
//! | plane, n · offset of a tap | 10 | −2^14 | 2^14 |
//!
//! Worked value: level 0, n = (0, 1024, 0), p = (26000, 34406, 37300) is (6.35, 8.4, 9.11), h = 0. The centre
//! is 410 above p, so plane = −(1024 · 410 >> 12) = −102. A tap with offset (1, 0, −1) has 0 >= −102 and
//! counts; one with (0, −1, 0) has −1024 and does not.

use adumbra::query::FIXED_BITS;

/// Fractional bits of a receiver's normal and height.
pub(crate) const NORMAL_BITS: u32 = 10;
/// The value 1 in the fixed point of normals and heights.
pub const NORMAL_ONE: i32 = 1 << NORMAL_BITS;
/// Limit that heights are clamped to, in cells: farther than any tap.
pub const MAX_HEIGHT_CELLS: i32 = 8;

/// A point as look-ups use it: its position after bias and entry into the cube, the size of the cells, and
/// the data that decides which taps are in front of its surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TreeReceiver {
    /// Position from the lowest corner of the cube, within the cube; one voxel is
    /// [`adumbra::query::FIXED_ONE`].
    pub p_fixed: [i32; 3],
    /// Level of the cells: a cell has sides of 2^level voxels.
    pub level: u32,
    /// Unit normal; 1 is [`NORMAL_ONE`]. Zero if the normal is unknown or every tap counts.
    pub normal: [i32; 3],
    /// Height of the point above the plane of its surface, along the normal, in cells; one cell is
    /// [`NORMAL_ONE`].
    pub height: i32,
}

impl TreeReceiver {
    /// `p_tree` is in voxels, within a cube of `side` voxels; `height` is in cells. Positions are rounded
    /// down, the others to nearest.
    pub(crate) fn new(p_tree: [f64; 3], side: u32, level: u32, normal: [f64; 3], height: f64) -> Self {
        let end = (side << FIXED_BITS) as i32 - 1;
        let p_fixed = p_tree.map(|c| ((c * f64::from(1 << FIXED_BITS)).floor() as i32).clamp(0, end));
        let round = |v: f64, limit: i32| {
            ((v * f64::from(NORMAL_ONE) + 0.5).floor() as i32).clamp(-limit * NORMAL_ONE, limit * NORMAL_ONE)
        };
        Self { p_fixed, level, normal: normal.map(|c| round(c, 1)), height: round(height, MAX_HEIGHT_CELLS) }
    }

    /// Returns the cell at the centre of the kernel.
    pub(crate) fn cell(&self) -> [i32; 3] {
        self.p_fixed.map(|c| c >> (FIXED_BITS + self.level))
    }

    /// Returns the threshold on n · offset: a tap is in front of the receiver's surface if its n · offset is
    /// at least this.
    pub(crate) fn plane(&self) -> i32 {
        let one = 1 << FIXED_BITS;
        let mut base = self.height * one;
        for (n, p) in self.normal.into_iter().zip(self.p_fixed) {
            base += n * (one / 2 - ((p >> self.level) & (one - 1)));
        }
        -(base >> FIXED_BITS)
    }

    /// Whether a tap counts: the centre tap always, the others if they are in front of the surface.
    pub(crate) fn counts(&self, plane: i32, offset: [i32; 3]) -> bool {
        let along: i32 = self.normal.into_iter().zip(offset).map(|(n, o)| n * o).sum();
        along >= plane || offset == [0; 3]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tree_receiver_worked_values() {
        let r = TreeReceiver::new([6.348, 8.4, 9.107], 16, 0, [0.0, 1.0, 0.0], 0.0);
        assert_eq!((r.p_fixed, r.normal, r.height), ([26001, 34406, 37302], [0, 1024, 0], 0));
        assert_eq!((r.cell(), r.plane()), ([6, 8, 9], -102));
        assert!(r.counts(-102, [1, 0, -1]) && !r.counts(-102, [0, -1, 0]) && r.counts(-102, [0; 3]));
        // In cells of 4 voxels its y is 2.1.
        let coarse = TreeReceiver { level: 2, ..r };
        assert_eq!((coarse.cell(), coarse.plane()), ([1, 2, 2], -((1024 * 1639) >> 12)));
    }

    #[test]
    fn tree_receiver_clamps_values_out_of_range() {
        let r = TreeReceiver::new([-0.1, 16.0, 3.0], 16, 1, [2.0, -2.0, f64::NAN], 1e9);
        assert_eq!(r.p_fixed, [0, 65535, 12288]);
        assert_eq!((r.normal, r.height), ([1024, -1024, 0], 8192));
        assert_eq!(TreeReceiver::new([0.0; 3], 16, 1, [0.0; 3], -1e9).height, -8192);
    }
}
