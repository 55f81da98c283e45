//! A point of a tree's cube in fixed point: from here on a look-up with its kernel is whole numbers, so that CPU and GPU agree
//! to the last tap. `spec/adumbra-tree.md`, "Look-up with a kernel", has the rule.
//!
//! | number | bits behind the point | from | to |
//! |---|---|---|---|
//! | position p, voxels | 12 | 0 | 2^27 − 1: a side has at most 2^15 voxels |
//! | normal n | 10 | −1024 | 1024 |
//! | height h over the receiver's plane, cells | 10 | −8192 | 8192 |
//! | middle of the point's cell − p, cells | 12 | −2047 | 2048 |
//! | n · (middle − p) + 4096 h | 22 | −2^26 | 2^26 |
//! | plane, n · offset of a tap | 10 | −2^14 | 2^14 |
//!
//! Worked value: level 0, n = (0, 1024, 0), p = (26000, 34406, 37300) is (6.35, 8.4, 9.11), h = 0: the middle is 410 above p, so
//! plane = −(1024 · 410 >> 12) = −102. A tap of offset (1, 0, −1) has 0 >= −102 and counts; one of (0, −1, 0) has −1024 and does not.

use super::fixed::FIXED_BITS;

/// Bits behind the point of a receiver's normal and height.
pub const NORMAL_BITS: u32 = 10;
/// 1 in normals and heights.
pub const NORMAL_ONE: i32 = 1 << NORMAL_BITS;
/// Heights are clamped to this many cells: more than any tap is away.
pub const MAX_HEIGHT_CELLS: i32 = 8;

/// What answers a point: where it stands after bias and entry, how coarse the cells are, and which taps lie before its surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TreeReceiver {
    /// Voxels from the cube's lowest corner, [`super::FIXED_ONE`] to a voxel; within the cube.
    pub p_fixed: [i32; 3],
    /// A cell has 2^level voxels a side.
    pub level: u32,
    /// Unit normal, [`NORMAL_ONE`] to 1; zero where none is known or every tap counts.
    pub normal: [i32; 3],
    /// How far the point stands above the plane of its surface, along the normal, in cells, [`NORMAL_ONE`] to one.
    pub height: i32,
}

impl TreeReceiver {
    /// `p_tree` in voxels, within a cube of `side` voxels; `height` in cells. Positions are rounded down, the others to the
    /// nearest.
    pub(super) fn new(p_tree: [f64; 3], side: u32, level: u32, normal: [f64; 3], height: f64) -> Self {
        let end = (side << FIXED_BITS) as i32 - 1;
        let p_fixed = p_tree.map(|c| ((c * f64::from(1 << FIXED_BITS)).floor() as i32).clamp(0, end));
        let round = |v: f64, limit: i32| {
            ((v * f64::from(NORMAL_ONE) + 0.5).floor() as i32).clamp(-limit * NORMAL_ONE, limit * NORMAL_ONE)
        };
        Self { p_fixed, level, normal: normal.map(|c| round(c, 1)), height: round(height, MAX_HEIGHT_CELLS) }
    }

    /// The cell in the middle.
    pub(super) fn cell(&self) -> [i32; 3] {
        self.p_fixed.map(|c| c >> (FIXED_BITS + self.level))
    }

    /// A tap of this offset lies before the receiver's surface where n · offset is at least this.
    pub(super) fn plane(&self) -> i32 {
        let one = 1 << FIXED_BITS;
        let mut base = self.height * one;
        for (n, p) in self.normal.into_iter().zip(self.p_fixed) {
            base += n * (one / 2 - ((p >> self.level) & (one - 1)));
        }
        -(base >> FIXED_BITS)
    }

    /// Whether a tap counts: the middle always, the others where they lie before the surface.
    pub(super) fn counts(&self, plane: i32, offset: [i32; 3]) -> bool {
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
        // In cells of 4 voxels it stands at 2.1 of them.
        let coarse = TreeReceiver { level: 2, ..r };
        assert_eq!((coarse.cell(), coarse.plane()), ([1, 2, 2], -((1024 * 1639) >> 12)));
    }

    #[test]
    fn tree_receiver_clamps_what_leaves_its_range() {
        let r = TreeReceiver::new([-0.1, 16.0, 3.0], 16, 1, [2.0, -2.0, f64::NAN], 1e9);
        assert_eq!(r.p_fixed, [0, 65535, 12288]);
        assert_eq!((r.normal, r.height), ([1024, -1024, 0], 8192));
        assert_eq!(TreeReceiver::new([0.0; 3], 16, 1, [0.0; 3], -1e9).height, -8192);
    }
}
