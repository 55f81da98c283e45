//! Blocks of eight siblings as the builders and reductions produce them, and their canonical numbering.

use crate::tree::graph::VoxelTree;
use crate::tree::word::Word;

/// Maximum number of blocks that the 31 index bits of a word can address.
pub const MAX_BLOCKS: usize = (1 << 31) / 8 - 1;

/// A tree or graph whose inner words are indices into `blocks`. Children precede their parents.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Blocks {
    /// The root node.
    pub root: Word,
    /// Eight siblings each.
    pub blocks: Vec<[Word; 8]>,
}

impl Blocks {
    /// Converts the tree to the words of the file, with its blocks in pre-order of first visit. Unreachable
    /// blocks are dropped.
    ///
    /// Cost: linear; two words per block besides the result.
    pub fn number(&self, depth: u32) -> VoxelTree {
        const UNSEEN: u32 = u32::MAX;
        let mut numbers = vec![UNSEEN; self.blocks.len()];
        let mut order = Vec::new();
        let mut waiting = Vec::new();
        waiting.extend(self.root.inner());
        while let Some(block) = waiting.pop() {
            let number = &mut numbers[block as usize];
            if *number != UNSEEN {
                continue;
            }
            *number = order.len() as u32;
            order.push(block);
            for child in self.blocks[block as usize].iter().rev() {
                if let Some(below) = child.inner()
                    && numbers[below as usize] == UNSEEN
                {
                    waiting.push(below);
                }
            }
        }
        let renumber = |word: Word| word.map_inner(|block| 1 + 8 * numbers[block as usize]).0;
        let mut words = Vec::with_capacity(1 + 8 * order.len());
        words.push(renumber(self.root));
        words.extend(order.iter().flat_map(|&b| self.blocks[b as usize].map(renumber)));
        VoxelTree { depth, words }
    }

    /// Returns the blocks of a numbered tree, reordered so that children precede their parents.
    pub fn of(tree: &VoxelTree) -> Self {
        // A numbered block may refer to a block before it, so reversing the order is not enough; a walk puts
        // children first.
        let count = tree.words.len() / 8;
        let mut place = vec![u32::MAX; count];
        let mut blocks = Vec::with_capacity(count);
        let block_of = |word: u32| Word(word).inner().map(|index| index / 8);
        let mut path: Vec<(u32, u32)> = block_of(tree.words[0]).map(|b| (b, 0)).into_iter().collect();
        while let Some((block, next)) = path.last_mut() {
            let at = 1 + 8 * *block as usize;
            if *next == 8 {
                place[*block as usize] = blocks.len() as u32;
                let placed = |index: u32| place[index as usize / 8];
                blocks.push(std::array::from_fn(|c| Word(tree.words[at + c]).map_inner(placed)));
                path.pop();
                continue;
            }
            let below = block_of(tree.words[at + *next as usize]);
            *next += 1;
            if let Some(b) = below.filter(|&b| place[b as usize] == u32::MAX) {
                path.push((b, 0));
            }
        }
        let root = Word(tree.words[0]).map_inner(|index| place[index as usize / 8]);
        Self { root, blocks }
    }
}
