//! One byte a leaf voxel, kept apart from the tree, so that subtrees merge whatever their voxels carry. Source: Dado, Kol,
//! Bauszat, Thiery, Eisemann, *Geometry and Attribute Compression for Voxel Scenes* (2016); the paper's §1.3.
//!
//! A leaf voxel is a cell of a leaf of eight, at one of the places where that leaf stands. The bytes stand in the order
//! in which a depth-first walk over the expanded tree meets their voxels, children in order, eight a leaf. So a voxel's index
//! is a sum over its path: the leaf voxels below the siblings before each node, and at last its number in the leaf.
//!
//! | memory | size |
//! |---|---|
//! | values | one byte a leaf voxel of the expanded tree |
//! | prefix counts | four bytes a word of the graph; not stored, recomputed at load |
//!
//! Departures: the authors put an offset beside each pointer and compress the values with a palette; here a count stands
//! beside each word, uniform ones too, and the values are left as they are.

use super::morton::{self, child_corner};
use super::word::Node;
use super::{VoxelTree, leaf_voxels};
use crate::error::{Error, Result};

/// Where the values of a tree's leaf voxels stand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AttributeIndex {
    /// For each word, leaf voxels below the siblings before it; 0 for the root.
    before: Vec<u32>,
    leaf_voxels: u32,
}

impl AttributeIndex {
    /// Counts the leaf voxels below each word. Cost: one walk over the graph; four bytes a word, and half a byte a word
    /// while it runs.
    ///
    /// # Errors
    /// [`Error::MemoryLimit`] where the tree has 2^32 leaf voxels or more.
    pub fn of(tree: &VoxelTree) -> Result<Self> {
        let words = tree.words().len();
        let mut counts = Counts { tree, before: vec![0; words], below: vec![UNKNOWN; words / 8] };
        let Some(leaf_voxels) = counts.below(tree.node(0)) else {
            let needed_bytes = leaf_voxels(tree);
            let what = "a value for each of 2^32 leaf voxels or more";
            return Err(Error::MemoryLimit { what, needed_bytes, limit_bytes: u64::from(u32::MAX) });
        };
        Ok(Self { before: counts.before, leaf_voxels })
    }

    /// Leaf voxels of the expanded tree.
    pub fn leaf_voxels(&self) -> u64 {
        u64::from(self.leaf_voxels)
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> u64 {
        (self.before.capacity() * size_of::<u32>()) as u64
    }

    /// Index of the value of voxel (x, y, z), each below [`VoxelTree::side`]; none where it lies in a uniform leaf. All
    /// finest voxels of a bigger cell have one value. `tree` is the one that the index was made for.
    ///
    /// Cost: one word and one count a level.
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

/// No block has that many: where one had, the tree is refused.
const UNKNOWN: u32 = u32::MAX;

struct Counts<'t> {
    tree: &'t VoxelTree,
    before: Vec<u32>,
    /// By block.
    below: Vec<u32>,
}

impl Counts<'_> {
    /// Leaf voxels below a node; none where 32 bits do not hold them.
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

/// Leaf voxels from which on the two halves of a node are walked by two threads.
const SPLIT: usize = 1 << 12;

/// Asks for the value of every leaf voxel: `value` is given the lowest voxel of its cell and the cell's level, 0 = a
/// finest voxel. `index` is the one made for `tree`. Value i is that of the leaf voxel which
/// [`AttributeIndex::locate`] puts at i.
///
/// Cost: linear in the expanded tree's leaves, on the threads of the current rayon pool; the bytes do not depend on how
/// many there are.
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
    /// Fills the values below the node at `word`, a cube of 2^level voxels a side.
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

    /// Fills the values below some of the children of a node, a power of two of them.
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
        // An index of another tree gives values that mean nothing, but no panic.
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
