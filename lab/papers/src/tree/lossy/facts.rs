//! The facts that a lossy merge stores about each block.

use crate::tree::word::{Node, Word};

/// Upper bound of how much a share of lit voxels is too low: it is exact up to level 10, and each level above
/// rounds down.
pub(crate) const LIT_ERROR: u64 = 4;

/// Properties of a block of the new graph.
#[derive(Clone, Copy)]
pub(crate) struct Facts {
    /// Whether the block occurs only once.
    pub(crate) single: bool,
    /// Level of the node that the block belongs to, if it occurs once.
    pub(crate) level: u8,
    /// Number of blocks saved if this one is replaced: itself and those below it that occur nowhere else.
    pub(crate) saved: u32,
    /// Share of its voxels that are lit, in units of 2^-32, too low by at most [`LIT_ERROR`].
    pub(crate) lit: u32,
}

impl Facts {
    /// Marks the block as occurring several times.
    pub(crate) fn stays(&mut self) {
        *self = Self { single: false, level: 0, saved: 0, lit: self.lit };
    }
}

/// Returns the share of the voxels of a node that are lit, in units of 2^-32.
pub(crate) fn lit(word: Word, facts: &[Facts]) -> u64 {
    match word.node() {
        Node::Inner(block) => u64::from(facts[block as usize].lit),
        Node::Mask(bits) => u64::from(bits.count_ones()) << 29,
        Node::Uniform(lit) => u64::from(lit) << 32,
    }
}
