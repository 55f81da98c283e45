//! Counts the voxels in which two trees differ, exactly. Voxels of the expanded tree count, so a block with a
//! thousand occurrences counts a thousand times. The count does not depend on how a tree was made, so it
//! verifies a lossy merge independently.
//!
//! The count cannot overflow: a tree of [`crate::tree::MAX_DEPTH`] levels has 2^45 voxels.

use hashbrown::HashMap;

use crate::tree::graph::VoxelTree;
use crate::tree::word::{Node, Word};

/// Returns the number of voxels of the finest level in which two trees of equal depth differ, or the number
/// of all voxels of the deeper tree if the depths differ.
///
/// Cost: one comparison per pair of blocks compared. Pairs are cached only if the block of the first tree
/// occurs several times; the others are compared once.
pub fn changed_voxels(a: &VoxelTree, b: &VoxelTree) -> u64 {
    if a.depth() != b.depth() {
        return 1 << (3 * a.depth().max(b.depth()));
    }
    let mut comparison = Comparison { a, b, shared: shared(a), known: HashMap::new() };
    comparison.pair(Word(a.words()[0]), Word(b.words()[0]), a.depth())
}

struct Comparison<'t> {
    a: &'t VoxelTree,
    b: &'t VoxelTree,
    /// For each block of `a`, whether it occurs more than once.
    shared: Vec<bool>,
    /// Cached counts, by block of `a` (28 bits), block of `b` (28 bits) and level (4 bits).
    known: HashMap<u64, u64>,
}

impl Comparison<'_> {
    /// Returns the number of voxels in which two nodes of the same level differ.
    fn pair(&mut self, a: Word, b: Word, level: u32) -> u64 {
        match (a.node(), b.node()) {
            (Node::Uniform(x), Node::Uniform(y)) => u64::from(x != y) << (3 * level),
            (Node::Inner(x), Node::Inner(y)) => {
                let key = u64::from(x / 8) << 32 | u64::from(y / 8) << 4 | u64::from(level);
                let shared = self.shared[x as usize / 8];
                if shared && let Some(&count) = self.known.get(&key) {
                    return count;
                }
                let count = self.children(a, b, level);
                if shared {
                    self.known.insert(key, count);
                }
                count
            }
            (Node::Mask(x), Node::Mask(y)) => u64::from((x ^ y).count_ones()) << (3 * (level - 1)),
            _ => self.children(a, b, level),
        }
    }

    fn children(&mut self, a: Word, b: Word, level: u32) -> u64 {
        (0..8).map(|c| self.pair(child(self.a, a, c), child(self.b, b, c), level - 1)).sum()
    }
}

/// Returns child `c` of a node; the child of a uniform node is the node itself.
fn child(tree: &VoxelTree, word: Word, c: u32) -> Word {
    match word.node() {
        Node::Uniform(_) => word,
        Node::Mask(mask) => Word::new(Node::Uniform(mask >> c & 1 == 1)),
        Node::Inner(index) => Word(tree.words()[(index + c) as usize]),
    }
}

/// Returns for each block whether it occurs more than once: blocks that several words point to, and all
/// blocks below them.
fn shared(tree: &VoxelTree) -> Vec<bool> {
    let block_of = |word: &u32| Word(*word).inner().map(|index| index as usize / 8);
    let mut met = vec![false; tree.words().len() / 8];
    let mut shared = met.clone();
    let mut waiting = Vec::new();
    for block in tree.words().iter().filter_map(block_of) {
        if met[block] && !shared[block] {
            shared[block] = true;
            waiting.push(block);
        }
        met[block] = true;
    }
    while let Some(block) = waiting.pop() {
        for below in tree.words()[1 + 8 * block..][..8].iter().filter_map(block_of) {
            if !shared[below] {
                shared[below] = true;
                waiting.push(below);
            }
        }
    }
    shared
}
