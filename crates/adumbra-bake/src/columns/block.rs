//! The columns of an 8 × 8 block, the input of sinks.

use super::rules::{BESIDE_GRID, Columns};
use crate::texel_mask::texels_where;

/// Side of the smallest block, in columns.
pub(crate) const BLOCK_SIDE: usize = 8;

/// `[e, x]` of an 8 × 8 block of columns, texel y·8 + x. Columns outside the grid are `[0, BESIDE_GRID]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct BlockColumns {
    pub(crate) e: [u32; BLOCK_SIDE * BLOCK_SIDE],
    pub(crate) x: [u32; BLOCK_SIDE * BLOCK_SIDE],
}

impl BlockColumns {
    /// Returns columns that may be anything.
    pub(crate) fn free() -> Self {
        Self { e: [0; BLOCK_SIDE * BLOCK_SIDE], x: [BESIDE_GRID; BLOCK_SIDE * BLOCK_SIDE] }
    }

    /// Returns the columns whose voxel k must be lit.
    pub(crate) fn must_be_lit(&self, k: u32) -> u64 {
        texels_where(|i| k < self.e[i])
    }

    /// Returns the columns whose voxel k must be shadowed.
    pub(crate) fn must_be_shadowed(&self, k: u32) -> u64 {
        texels_where(|i| k >= self.x[i])
    }

    /// Pads at most 8 × 8 columns to a block. Missing columns are free.
    pub(crate) fn padded(columns: &Columns) -> Self {
        let mut block = Self::free();
        let width = columns.width as usize;
        for y in 0..columns.height as usize {
            let (from, to) = (y * width, y * BLOCK_SIDE);
            block.e[to..to + width].copy_from_slice(&columns.e[from..from + width]);
            block.x[to..to + width].copy_from_slice(&columns.x[from..from + width]);
        }
        block
    }
}
