//! How far behind its first surface a column may switch; in a block that is resolved undrawn, how far behind the deepest first surface of
//! the block. The columns' own rules ask only what a receiver finds in its own
//! column; a filter reads the columns beside it too, and in those of a wall, at the depth of the wall's foot, finds a voxel
//! inside the wall. Where that is free and lit, the contact shadow pales within the filter's reach. So the freedom is cut.
//!
//! `docs/layouts.md` has what it costs and what it mends.

use super::columns::{BESIDE_GRID, Columns};
use super::sink::{BlockColumns, BlockSink};

/// The freedom that is left of an interval.
#[derive(Clone, Copy)]
pub(super) struct Early {
    /// Voxels from the first surface; 0 = all of the interval.
    pub(super) within_voxels: u32,
    /// Of the grid.
    pub(super) depth_voxels: u32,
}

impl Early {
    /// What is left of `[e, x]`; columns without a surface, and those beside the grid, stay as they are.
    fn interval(self, [e, x]: [u32; 2]) -> [u32; 2] {
        if self.within_voxels == 0 || x == BESIDE_GRID || e >= self.depth_voxels {
            return [e, x];
        }
        [e, x.min(e.saturating_add(self.within_voxels)).min(self.depth_voxels - 1)]
    }

    /// The same of every column.
    pub(super) fn cut(self, columns: &mut Columns) {
        for (e, x) in columns.e.iter().zip(&mut columns.x) {
            [_, *x] = self.interval([*e, *x]);
        }
    }
}

/// Hands blocks on, their intervals cut.
pub(super) struct EarlySink<'a, S> {
    pub(super) early: Early,
    pub(super) sink: &'a S,
}

impl<S: BlockSink> BlockSink for EarlySink<'_, S> {
    type Block = S::Block;

    fn uniform(&self, level: u32, interval: [u32; 2]) -> S::Block {
        self.sink.uniform(level, self.early.interval(interval))
    }

    fn leaf(&self, columns: &BlockColumns) -> S::Block {
        if self.early.within_voxels == 0 {
            return self.sink.leaf(columns);
        }
        let mut cut = columns.clone();
        for (e, x) in columns.e.iter().zip(&mut cut.x) {
            [_, *x] = self.early.interval([*e, *x]);
        }
        self.sink.leaf(&cut)
    }

    fn join(&self, level: u32, quarters: [S::Block; 4]) -> S::Block {
        self.sink.join(level, quarters)
    }
}

#[cfg(test)]
mod tests {
    use super::super::columns::FREE_TO_END;
    use super::*;

    #[test]
    fn early_switches_stay_in_their_interval_and_near_its_start() {
        let cut = |within_voxels, interval| Early { within_voxels, depth_voxels: 100 }.interval(interval);
        assert_eq!(cut(8, [10, 50]), [10, 18]);
        assert_eq!(cut(8, [10, 12]), [10, 12]);
        assert_eq!(cut(8, [10, FREE_TO_END]), [10, 18]);
        // A surface near the grid's end still casts; one at its end, or none, does not.
        assert_eq!(cut(8, [97, FREE_TO_END]), [97, 99]);
        assert_eq!(cut(8, [100, FREE_TO_END]), [100, FREE_TO_END]);
        assert_eq!(cut(8, [0, BESIDE_GRID]), [0, BESIDE_GRID]);
        // What lies sunward of a box that was asked for.
        assert_eq!(cut(8, [0, FREE_TO_END]), [0, 8]);
        assert_eq!(cut(0, [10, FREE_TO_END]), [10, FREE_TO_END]);
    }
}
