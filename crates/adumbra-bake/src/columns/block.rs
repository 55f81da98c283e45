//! The columns of an 8 × 8 block, the input of sinks.

use super::rules::{BESIDE_GRID, Columns};

/// Side of the smallest block, in columns.
pub(crate) const BLOCK_SIDE: usize = 8;

/// `[e, x]` of an 8 × 8 block of columns, texel y·8 + x. Columns outside the grid are `[0, BESIDE_GRID]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockColumns {
    /// First voxel of each column that need not be lit.
    pub e: [u32; BLOCK_SIDE * BLOCK_SIDE],
    /// First voxel of each column that must be shadowed.
    pub x: [u32; BLOCK_SIDE * BLOCK_SIDE],
}

impl BlockColumns {
    /// Returns columns that may be anything.
    pub fn free() -> Self {
        Self { e: [0; BLOCK_SIDE * BLOCK_SIDE], x: [BESIDE_GRID; BLOCK_SIDE * BLOCK_SIDE] }
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
