//! The interface between scene traversal and the structures that a bake builds from columns, block by block,
//! bottom up.
//!
//! A block is a square of 2^level × 2^level columns, aligned to its size; the smallest level is 3. A column's
//! `[e, x]` means that it may switch from lit to shadowed anywhere in that interval: voxel k must be lit if k
//! < e, and shadowed if k >= x. If x is [`FREE_TO_END`](crate::columns::rules::FREE_TO_END) or more, no voxel
//! of the column must be shadowed.

pub(crate) mod depths;
#[cfg(test)]
mod depths_tests;
pub(crate) mod from_columns;
pub(crate) mod recent;
mod undecided;

use adumbra::layout::depths::LEAF_LEVEL;

use crate::columns::BlockColumns;
use crate::error::Result;

/// Level of the largest blocks that sinks hold undecided.
const MAX_HELD_LEVEL: u32 = 9;
/// Bytes of an undecided leaf, as sinks hold it until the root block above it is done: a few depths, their
/// order and the allocator's share.
const HELD_LEAF_BYTES: u64 = 512;

/// Returns the bytes that a sink holds for the root block that a worker is building.
pub(crate) fn building_bytes(root_level: u32) -> u64 {
    HELD_LEAF_BYTES << (2 * (root_level.min(MAX_HELD_LEVEL) - LEAF_LEVEL))
}

/// A structure that is built from blocks. Calls come from many threads. Equal calls must return blocks of
/// equal meaning in whatever order they come, because the finished bytes must not depend on it.
pub trait BlockSink: Sync {
    /// A finished block, held until its parent takes it.
    type Block: Send;

    /// Returns a block of 2^level columns a side, each of which may switch anywhere in `[e, x]`, e <= x. x
    /// may be [`FREE_TO_END`](crate::columns::rules::FREE_TO_END) or more, and e may be the grid's depth.
    fn uniform(&self, level: u32, interval: [u32; 2]) -> Self::Block;

    /// Returns a block of level 3 with the given columns.
    fn leaf(&self, columns: &BlockColumns) -> Self::Block;

    /// Returns root block `number`, x fastest, if the sink has it already, so that it need not be built.
    fn known(&self, number: usize) -> Option<Self::Block>;

    /// Joins four quarters of the level below into a block of `level`; a quarter's index is `x_bit << 1 |
    /// y_bit`.
    fn join(&self, level: u32, quarters: [Self::Block; 4]) -> Self::Block;

    /// Offers root block `number`, x fastest, as soon as it is done. The sink may take it and return another
    /// in its place.
    fn taken(&self, number: usize, block: Self::Block) -> Self::Block;
}

/// A sink that makes something of all root blocks.
pub trait Structure: BlockSink + Sized {
    /// What it makes.
    type Output;
    /// What errors call the structure while blocks are added to it.
    const SO_FAR: &'static str;
    /// What errors call the work of [`Structure::finish`].
    const FINISHING: &'static str;

    /// Bytes held for finished blocks, apart from what is paged.
    fn memory_bytes(&self) -> u64;

    /// Bytes of the result so far, in memory or on disk.
    fn result_bytes(&self) -> u64;

    /// Bytes that [`Structure::finish`] needs in addition to what is held.
    fn finish_bytes(&self) -> u64;

    /// Checks that addresses can tell all parts of the structure apart, with room for what the blocks in
    /// progress add.
    ///
    /// # Errors
    /// Returns [`Error::TooManyWords`](crate::Error::TooManyWords).
    fn check_room(&self) -> Result<()>;

    /// Moves to disk what is in memory beyond the room there is, if anything can be moved.
    fn make_room(&self) {}

    /// Makes the result from the root blocks, x fastest.
    fn finish(self, blocks: Vec<Self::Block>) -> Self::Output;
}
