//! The tree in bytes instead of words: pointers of variable width and, if asked for, mirror images as one node.
//!
//! Source: Jaspe Villanueva, Marton, Gobbetti, *SSVDAGs: Symmetry-aware Sparse Voxel DAGs* (2016). Departures: children
//! have kinds of three bits, not two; leaves of eight voxels stand in their parent; a node that is used once follows its
//! parent; nodes are turned to the image that is used most, so that most pointers need no mirror bits. `node.rs` has the bit
//! table.
//!
//! Measured on made-up worlds of 2^11 voxels a side under a slanted sun, insides of solids free: 400 boxes along the
//! axes, 400 turned ones, a landscape. Bytes as a share of the words':
//!
//! | layout | boxes | turned | landscape |
//! |---|---|---|---|
//! | pointers of 2, 3, 4 bytes by use alone | 0.367 | 0.374 | 0.304 |
//! | the same with 1 byte and two sets of 2 | 0.339 | 0.350 | 0.269 |
//! | this one without the kind of no bytes | 0.344 | 0.350 | 0.273 |
//! | this one | 0.311 | 0.321 | 0.252 |
//! | the first with mirrors | 0.381 | 0.384 | 0.312 |
//! | this one with mirrors | 0.317 | 0.328 | 0.258 |
//!
//! Mirrors take away 3 % of the nodes there, up to 7 % at 2^9 a side, but make pointers wider, and so lose more than they
//! gain from 2^10 on: a slanted sun leaves few images in a world's shadows. Addresses in units of 2 bytes lost 0.5 to
//! 11 % at 2^9 whatever the layout, of 4 bytes 8 to 26 %. At 2^10 a look-up takes 21 to 30 ns at random voxels, where words
//! take 14 to 20; 59 to 70 ns where it ends in one of eight voxels, where words take 22 to 32.

mod decode;
mod encode;
mod look_up;
mod mirror;
mod node;
mod validate;

pub use validate::SymmetricError;

use super::{Blocks, VoxelTree};
use crate::error::Result;

/// A cube of 2^depth voxels a side, as bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SymmetricTree {
    depth: u32,
    mirrors: bool,
    nodes: u64,
    bytes: Vec<u8>,
}

impl SymmetricTree {
    /// The bytes of a tree. The same tree gives the same bytes.
    ///
    /// # Errors
    /// [`crate::Error::MemoryLimit`] where four bytes do not reach: 2 GiB, 512 MiB with mirrors.
    pub fn of(tree: &VoxelTree, mirrors: bool) -> Result<Self> {
        let mut graph = mirror::mirror(&Blocks::of(tree), mirrors);
        graph.turn_to_most_used();
        let bytes = encode::encode(&graph, mirrors)?;
        Ok(Self { depth: tree.depth(), mirrors, nodes: graph.nodes.len() as u64, bytes })
    }

    /// Checks bytes and takes them. Whatever is taken can be looked up and unpacked; it need not be the one form that
    /// [`SymmetricTree::of`] gives, which may be shorter. What `of` made is taken, and is what
    /// `of(&self.to_tree()?, self.mirrors())` makes again.
    ///
    /// # Errors
    /// The first thing that is wrong, as a [`SymmetricError`].
    pub fn from_bytes(depth: u32, bytes: Vec<u8>) -> Result<Self, SymmetricError> {
        let nodes = validate::check(depth, &bytes)?;
        let mirrors = node::word_at(&bytes, 0) & encode::MIRRORS != 0;
        Ok(Self { depth, mirrors, nodes, bytes })
    }

    /// The whole body: header, nodes, padding.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Levels below the root.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Whether pointers have mirror bits.
    pub fn mirrors(&self) -> bool {
        self.mirrors
    }

    /// Nodes, leaves not counted.
    pub fn node_count(&self) -> u64 {
        self.nodes
    }
}

#[cfg(test)]
mod tests;
