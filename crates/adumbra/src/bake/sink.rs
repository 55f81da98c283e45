//! What a bake builds out of columns, block by block from the bottom: the seam between walking the scene and any structure
//! that answers.
//!
//! A block is a square of 2^level × 2^level columns, level 3 at the smallest, aligned to its size. A column's `[e, x]` says
//! that its switch from lit to shadowed may stand anywhere in it: voxel k must be lit where k < e, shadowed where k >= x.
//! x = [`FREE_TO_END`](super::columns::FREE_TO_END) or more: no voxel of the column must be shadowed.

use super::columns::{BESIDE_GRID, Columns};
use super::texel_mask::texels_where;

/// Columns of the smallest block along a side.
pub(crate) const BLOCK_SIDE: usize = 8;

/// `[e, x]` of an 8 × 8 block of columns, texel y·8 + x; columns beside the grid are `[0, BESIDE_GRID]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct BlockColumns {
    pub(crate) e: [u32; BLOCK_SIDE * BLOCK_SIDE],
    pub(crate) x: [u32; BLOCK_SIDE * BLOCK_SIDE],
}

impl BlockColumns {
    /// Columns that may be anything.
    pub(crate) fn free() -> Self {
        Self { e: [0; BLOCK_SIDE * BLOCK_SIDE], x: [BESIDE_GRID; BLOCK_SIDE * BLOCK_SIDE] }
    }

    /// Columns whose voxel k must be lit.
    pub(crate) fn must_be_lit(&self, k: u32) -> u64 {
        texels_where(|i| k < self.e[i])
    }

    /// Columns whose voxel k must be shadowed.
    pub(crate) fn must_be_shadowed(&self, k: u32) -> u64 {
        texels_where(|i| k >= self.x[i])
    }

    /// At most 8 × 8 columns, what is missing free.
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

/// Something that grows from blocks. Calls come from many threads; equal calls must give blocks of equal meaning, whatever
/// the order, for the finished bytes may not depend on it.
pub(crate) trait BlockSink: Sync {
    /// What stands for a finished block until its parent takes it.
    type Block: Send;

    /// A block of 2^level columns a side, all of which may switch anywhere in `[e, x]`, e <= x; an x
    /// of [`FREE_TO_END`](super::columns::FREE_TO_END) or more and e = the grid's depth included.
    fn uniform(&self, level: u32, interval: [u32; 2]) -> Self::Block;

    /// A block of level 3 from its columns.
    fn leaf(&self, columns: &BlockColumns) -> Self::Block;

    /// A block of `level` from its quarters of the level below; quarter `x_bit << 1 | y_bit`.
    fn join(&self, level: u32, quarters: [Self::Block; 4]) -> Self::Block;
}
