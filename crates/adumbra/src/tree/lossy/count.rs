//! The voxels in which two trees differ, exactly. Places in the expanded tree count, so a block that stands in a thousand
//! places counts a thousand times. Nothing here knows how a tree came to be: what a lossy merge did is proved with it
//! afterwards.
//!
//! The count cannot overflow: a tree of [`crate::tree::MAX_DEPTH`] levels holds 2^45 voxels.

use hashbrown::HashMap;

use crate::tree::VoxelTree;
use crate::tree::word::{Node, Word};

/// Voxels of the finest level in which two trees of one depth differ; all of them where the depths are not the same.
///
/// Cost: one comparison a pair of blocks that meet; pairs are remembered only where the first tree's block stands in
/// several places, the others are met once.
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
    /// Whether a block of `a` stands in more than one place.
    shared: Vec<bool>,
    /// By block of `a` (28 bits), block of `b` (28 bits) and level (4 bits).
    known: HashMap<u64, u64>,
}

impl Comparison<'_> {
    /// Differing voxels of two nodes of one level.
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

/// Child `c` of a node; a uniform node's is as it is.
fn child(tree: &VoxelTree, word: Word, c: u32) -> Word {
    match word.node() {
        Node::Uniform(_) => word,
        Node::Mask(mask) => Word::new(Node::Uniform(mask >> c & 1 == 1)),
        Node::Inner(index) => Word(tree.words()[(index + c) as usize]),
    }
}

/// Which blocks stand in more than one place: those that several words point to, and all below them.
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
