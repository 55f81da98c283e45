//! Limits how far behind its first surface a column may switch. In a block that is resolved without being
//! drawn, the distance counts from the deepest first surface of the block.
//!
//! The column rules bound a column where receivers of the scene and the filters around them read it. A filter
//! around a point that is not part of the scene, such as a mover's beside a wall, may read elsewhere.
//!
//! `docs/layouts.md` documents the cost and the benefit.

use crate::columns::rules::BESIDE_GRID;

/// How much of a column's interval remains.
#[derive(Clone, Copy)]
pub(crate) struct SwitchLimit {
    /// Distance from the first surface, voxels; 0 = the whole interval.
    pub(crate) within_voxels: u32,
    /// Depth of the grid, voxels.
    pub(crate) depth_voxels: u32,
}

impl SwitchLimit {
    /// Cuts `[e, x]`. Columns without a surface, and those outside the grid, are unchanged.
    pub(crate) fn interval(self, [e, x]: [u32; 2]) -> [u32; 2] {
        if self.within_voxels == 0 || x == BESIDE_GRID || e >= self.depth_voxels {
            return [e, x];
        }
        [e, x.min(e.saturating_add(self.within_voxels)).min(self.depth_voxels - 1)]
    }

    /// Cuts the interval `[e, x]` of every column.
    pub(crate) fn cut(self, e: &[u32], x: &mut [u32]) {
        if self.within_voxels == 0 {
            return;
        }
        for (e, x) in e.iter().zip(x) {
            [_, *x] = self.interval([*e, *x]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::rules::FREE_TO_END;

    #[test]
    fn early_switches_stay_in_their_interval_and_near_its_start() {
        let cut =
            |within_voxels, interval| SwitchLimit { within_voxels, depth_voxels: 100 }.interval(interval);
        assert_eq!(cut(8, [10, 50]), [10, 18]);
        assert_eq!(cut(8, [10, 12]), [10, 12]);
        assert_eq!(cut(8, [10, FREE_TO_END]), [10, 18]);
        // A surface near the grid's end still casts; one at its end does not, nor does a column without one.
        assert_eq!(cut(8, [97, FREE_TO_END]), [97, 99]);
        assert_eq!(cut(8, [100, FREE_TO_END]), [100, FREE_TO_END]);
        assert_eq!(cut(8, [0, BESIDE_GRID]), [0, BESIDE_GRID]);
        // A caster sunward of the requested bounds.
        assert_eq!(cut(8, [0, FREE_TO_END]), [0, 8]);
        assert_eq!(cut(0, [10, FREE_TO_END]), [10, FREE_TO_END]);
    }
}
