//! The tree in bytes instead of words: pointers of variable width and, optionally, mirror images merged into
//! one node.
//!
//! Source: Jaspe Villanueva, Marton, Gobbetti, *SSVDAGs: Symmetry-aware Sparse Voxel DAGs* (2016).
//! Departures: the kinds of children have three bits, not two. Leaves of eight voxels are stored in their
//! parent. A node that is used once follows its parent. Nodes are turned to their most used image, so that
//! most pointers need no mirror bits. The bit table is in `node.rs`.
//!
//! Measured on generated worlds of 2^11 voxels a side under a slanted sun, with free insides of solids: 400
//! axis-aligned boxes, 400 rotated boxes, a landscape. Bytes relative to those of the words:
//!
//! | layout | boxes | rotated | landscape |
//! |---|---|---|---|
//! | A: pointers of 2, 3, 4 bytes by use count alone | 0.367 | 0.374 | 0.304 |
//! | B: as A, with 1-byte pointers and two sets of 2-byte ones | 0.339 | 0.350 | 0.269 |
//! | C: this layout without the zero-byte kind | 0.344 | 0.350 | 0.273 |
//! | D: this layout | 0.311 | 0.321 | 0.252 |
//! | A with mirrors | 0.381 | 0.384 | 0.312 |
//! | D with mirrors | 0.317 | 0.328 | 0.258 |
//!
//! Mirrors remove 3 % of the nodes there, up to 7 % at 2^9 a side, but they make pointers wider. From 2^10 up
//! they cost more than they save, because under a slanted sun few parts of a world's shadows are mirror
//! images of each other. Addresses in units of 2 bytes cost 0.5 to 11 % at 2^9 in every layout, in units of 4
//! bytes 8 to 26 %. At 2^10 a look-up takes 21 to 30 ns at random voxels, where words take 14 to 20; if it
//! ends in a leaf of eight, it takes 59 to 70 ns, where words take 22 to 32.

mod decode;
mod encode;
mod look_up;
mod mirror;
mod node;
mod validate;

use crate::tree::error::SymmetricError;

use crate::tree::blocks::Blocks;
use crate::tree::error::Result;
use crate::tree::graph::VoxelTree;

/// A cube with sides of 2^depth voxels, as bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SymmetricTree {
    depth: u32,
    mirrors: bool,
    nodes: u64,
    bytes: Vec<u8>,
}

impl SymmetricTree {
    /// Encodes a tree. The same tree gives the same bytes.
    ///
    /// # Errors
    /// Returns [`adumbra_bake::Error::TooManyWords`] if the body exceeds the range of four-byte addresses: 2
    /// GiB, or 512 MiB with mirrors.
    pub fn of(tree: &VoxelTree, mirrors: bool) -> Result<Self> {
        let mut graph = mirror::mirror(&Blocks::of(tree), mirrors);
        graph.turn_to_most_used();
        let bytes = encode::encode(&graph, mirrors)?;
        Ok(Self { depth: tree.depth(), mirrors, nodes: graph.nodes.len() as u64, bytes })
    }

    /// Checks bytes and takes ownership of them. Accepted bytes can be looked up and unpacked, but need not
    /// be the canonical form that [`SymmetricTree::of`] gives, which may be shorter. Bytes made by `of` are
    /// accepted, and are equal to those of `of(&self.to_tree()?, self.mirrors())`.
    ///
    /// # Errors
    /// Returns the first fault found, as a [`SymmetricError`].
    pub fn from_bytes(depth: u32, bytes: Vec<u8>) -> Result<Self, SymmetricError> {
        let nodes = validate::check(depth, &bytes)?;
        let mirrors = node::word_at(&bytes, 0) & encode::MIRRORS != 0;
        Ok(Self { depth, mirrors, nodes, bytes })
    }

    /// The whole body: header, nodes and padding.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Number of levels below the root.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Whether pointers can have mirror bits.
    pub fn mirrors(&self) -> bool {
        self.mirrors
    }

    /// Number of nodes, not counting leaves.
    pub fn node_count(&self) -> u64 {
        self.nodes
    }
}

#[cfg(test)]
mod tests;
