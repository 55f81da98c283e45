//! An attribute of one byte per leaf voxel, stored apart from the tree so that subtrees merge regardless of
//! the values of their voxels. Source: Dado, Kol, Bauszat, Thiery, Eisemann, *Geometry and Attribute
//! Compression for Voxel Scenes* (2016); the paper's §1.3.
//!
//! A leaf voxel is a cell of a leaf of eight, counted once for each occurrence of that leaf in the expanded
//! tree. The bytes are in the order in which a depth-first walk over the expanded tree visits their voxels:
//! children in order, eight bytes per leaf. The index of a voxel is therefore a sum along its path: the leaf
//! voxels below the preceding siblings of each node, plus the voxel's number within its leaf.
//!
//! | memory | size |
//! |---|---|
//! | values | one byte per leaf voxel of the expanded tree |
//! | prefix counts | four bytes per word of the graph; not stored, recomputed on load |
//!
//! Departures: the authors store an offset with each pointer and compress the values with a palette. Here
//! every word has a count, uniform ones included, and the values are not compressed.

use crate::tree::error::{Error, Result};
use crate::tree::graph::VoxelTree;
use crate::tree::leaf_voxels::leaf_voxels;
use crate::tree::morton;
use crate::tree::morton::child_corner;
use crate::tree::word::Node;

/// Maps the leaf voxels of a tree to the indices of their values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AttributeIndex {
    /// For each word, the number of leaf voxels below its preceding siblings; 0 for the root.
    before: Vec<u32>,
    leaf_voxels: u32,
}

impl AttributeIndex {
    /// Counts the leaf voxels below each word. Cost: one walk over the graph; four bytes per word, plus half
    /// a byte per word during the walk.
    ///
    /// # Errors
    /// Returns [`adumbra_bake::Error::MemoryLimit`] if the tree has 2^32 leaf voxels or more.
    pub fn of(tree: &VoxelTree) -> Result<Self> {
        let words = tree.words().len();
        let mut counts = Counts { tree, before: vec![0; words], below: vec![UNKNOWN; words / 8] };
        let Some(leaf_voxels) = counts.below(tree.node(0)) else {
            let needed_bytes = leaf_voxels(tree);
            let what = "a value for each of 2^32 leaf voxels or more";
            return Err(Error::memory(what, needed_bytes, u64::from(u32::MAX)));
        };
        Ok(Self { before: counts.before, leaf_voxels })
    }

    /// Number of leaf voxels of the expanded tree.
    pub fn leaf_voxels(&self) -> u64 {
        u64::from(self.leaf_voxels)
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> u64 {
        (self.before.capacity() * size_of::<u32>()) as u64
    }

    /// Returns the index of the value of voxel (x, y, z), each coordinate below
    /// [`VoxelTree::side`], or `None` if the voxel is in a uniform leaf. All finest voxels of a larger cell
    /// share one value. `tree` must be the tree that the index was built for.
    ///
    /// Cost: one word and one count per level.
    pub fn locate(&self, tree: &VoxelTree, xyz: [u32; 3]) -> Option<u32> {
        let (mut word, mut level, mut index) = (0, tree.depth(), 0_u32);
        loop {
            index = index.checked_add(*self.before.get(word as usize)?)?;
            level = level.checked_sub(1)?;
            let child = morton::child(xyz, level);
            match tree.node(word) {
                Node::Uniform(_) => return None,
                Node::Mask(_) => return index.checked_add(child),
                Node::Inner(first) => word = first + child,
            }
        }
    }
}

/// Marks a block that has not been counted yet. No block has this count: a tree with 2^32 leaf voxels or more
/// is refused.
const UNKNOWN: u32 = u32::MAX;

struct Counts<'t> {
    tree: &'t VoxelTree,
    before: Vec<u32>,
    /// Leaf voxels below each block.
    below: Vec<u32>,
}

impl Counts<'_> {
    /// Returns the number of leaf voxels below a node, or `None` if it exceeds 32 bits.
    fn below(&mut self, node: Node) -> Option<u32> {
        let first = match node {
            Node::Uniform(_) => return Some(0),
            Node::Mask(_) => return Some(8),
            Node::Inner(first) => first,
        };
        let block = first as usize / 8;
        if self.below[block] == UNKNOWN {
            let mut sum = 0_u32;
            for word in first..first + 8 {
                self.before[word as usize] = sum;
                sum = sum.checked_add(self.below(self.tree.node(word))?)?;
            }
            // Sums are multiples of eight, so none of them is UNKNOWN.
            self.below[block] = sum;
        }
        Some(self.below[block])
    }
}

/// Number of leaf voxels from which the two halves of a node are processed by two threads.
const SPLIT: usize = 1 << 12;

/// Collects the value of every leaf voxel. `value` receives the lowest voxel of the cell and the level of the
/// cell, 0 = a finest voxel. `index` must be the one built for `tree`. Value i belongs to the leaf voxel for
/// which [`AttributeIndex::locate`] returns i.
///
/// Cost: linear in the leaves of the expanded tree, on the threads of the current rayon pool. The bytes do
/// not depend on the number of threads.
pub fn gather(
    tree: &VoxelTree,
    index: &AttributeIndex,
    value: &(dyn Fn([u32; 3], u32) -> u8 + Sync),
) -> Vec<u8> {
    let mut values = vec![0; index.leaf_voxels as usize];
    Gather { tree, index, value }.node(0, [0; 3], tree.depth(), &mut values);
    values
}

struct Gather<'g> {
    tree: &'g VoxelTree,
    index: &'g AttributeIndex,
    value: &'g (dyn Fn([u32; 3], u32) -> u8 + Sync),
}

impl Gather<'_> {
    /// Fills the values below the node at `word`, a cube with sides of 2^level voxels.
    fn node(&self, word: u32, corner: [u32; 3], level: u32, values: &mut [u8]) {
        match self.tree.node(word) {
            Node::Uniform(_) => {}
            Node::Mask(_) => {
                for (c, v) in (0..8).zip(values) {
                    *v = (self.value)(child_corner(corner, level, c), level - 1);
                }
            }
            Node::Inner(first) => self.children(first, 0..8, corner, level, values),
        }
    }

    /// Fills the values below a range of the children of a node; the length of the range is a power of two.
    fn children(
        &self,
        first: u32,
        some: std::ops::Range<u32>,
        corner: [u32; 3],
        level: u32,
        values: &mut [u8],
    ) {
        if values.is_empty() {
            return;
        }
        if some.len() == 1 {
            return self.node(first + some.start, child_corner(corner, level, some.start), level - 1, values);
        }
        let middle = u32::midpoint(some.start, some.end);
        let before = |c: u32| self.index.before.get((first + c) as usize).copied().unwrap_or_default();
        let left = before(middle).saturating_sub(before(some.start)) as usize;
        let parallel = values.len() >= SPLIT;
        // With an index of another tree the values are meaningless, but there is no panic.
        let (low, high) = values.split_at_mut(left.min(values.len()));
        let mut a = || self.children(first, some.start..middle, corner, level, low);
        let mut b = || self.children(first, middle..some.end, corner, level, high);
        if parallel {
            rayon::join(a, b);
        } else {
            a();
            b();
        }
    }
}

#[cfg(test)]
mod tests;
