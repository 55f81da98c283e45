//! The paper's tree, or the graph that it reduces to, in 32-bit words.

use super::morton;
use super::word::{Node, Word};

/// Most levels of a tree.
pub const MAX_DEPTH: u32 = 15;

/// A cube of 2^depth voxels a side, as words: root at word 0, then blocks of eight siblings, child i of an inner node at
/// its index plus i (3-7). Blocks stand in pre-order of first visit, so one graph has one form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VoxelTree {
    pub(super) depth: u32,
    pub(super) words: Vec<u32>,
}

/// Why words are not a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TreeError {
    /// The depth is out of range.
    #[error("a depth of {depth} is not from 1 to {MAX_DEPTH}")]
    Depth {
        /// The depth given.
        depth: u32,
    },
    /// The words are not one root and whole blocks.
    #[error("{words} words are not a root and blocks of eight")]
    Length {
        /// Words given.
        words: usize,
    },
    /// A word has bits that no node has.
    #[error("word {index} is {word:#010x}, which is no node")]
    Word {
        /// Where it stands.
        index: usize,
        /// Its value.
        word: u32,
    },
    /// An index points outside the words or between blocks.
    #[error("word {index} points to word {target}, where no block begins")]
    Index {
        /// Where it stands.
        index: usize,
        /// Where it points.
        target: u32,
    },
    /// Blocks do not stand in the order in which a walk from the root first meets them, or are never met.
    #[error("the block at word {block} is not met where its place says")]
    Order {
        /// First word of the block.
        block: usize,
    },
    /// A node has more levels below it than the depth allows, or lies below itself.
    #[error("the block at word {block} lies deeper than {depth} levels")]
    TooDeep {
        /// First word of the block.
        block: usize,
        /// The tree's depth.
        depth: u32,
    },
    /// Eight uniform children in a block: their parent should be a leaf.
    #[error("the block at word {block} holds eight uniform children; its parent should be a leaf")]
    NotMerged {
        /// First word of the block.
        block: usize,
    },
}

impl VoxelTree {
    /// Checks `words` and takes them.
    ///
    /// # Errors
    /// The first thing that is wrong, as a [`TreeError`]. Cost: linear, one walk.
    pub fn from_words(depth: u32, words: Vec<u32>) -> Result<Self, TreeError> {
        check(depth, &words)?;
        Ok(Self { depth, words })
    }

    /// Levels below the root.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Voxels a side.
    pub fn side(&self) -> u32 {
        1 << self.depth
    }

    /// All words, root first.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// All words, root first, without a copy.
    pub fn into_words(self) -> Vec<u32> {
        self.words
    }

    /// Bytes of the words.
    pub fn bytes(&self) -> u64 {
        self.words.len() as u64 * 4
    }

    /// The node at a word.
    pub fn node(&self, index: u32) -> Node {
        Word(self.words[index as usize]).node()
    }

    /// Visibility of voxel (x, y, z), each below [`VoxelTree::side`]. Cost: at most one word a level.
    pub fn voxel(&self, xyz: [u32; 3]) -> bool {
        self.find(xyz).0
    }

    /// Visibility of voxel (x, y, z) and the level of the leaf that says so: 0 = a voxel.
    pub fn find(&self, xyz: [u32; 3]) -> (bool, u32) {
        let mut node = self.node(0);
        let mut level = self.depth;
        loop {
            match node {
                Node::Uniform(lit) => return (lit, level),
                Node::Mask(mask) => {
                    level -= 1;
                    return (mask >> morton::child(xyz, level) & 1 == 1, level);
                }
                Node::Inner(index) => {
                    level -= 1;
                    node = self.node(index + morton::child(xyz, level));
                }
            }
        }
    }
}

/// Where a walk stands in a block.
#[derive(Clone, Copy)]
struct Step {
    block: usize,
    next: usize,
    height: u8,
}

/// Whether words are a tree in its one form. Cost: linear, one walk.
pub(crate) fn check(depth: u32, words: &[u32]) -> Result<(), TreeError> {
    /// Heights of blocks that are not met yet, and of those that the walk is in.
    const UNMET: u8 = 0;
    const OPEN: u8 = 255;
    if !(1..=MAX_DEPTH).contains(&depth) {
        return Err(TreeError::Depth { depth });
    }
    if words.len() % 8 != 1 || words.len() > 1 << 31 {
        return Err(TreeError::Length { words: words.len() });
    }
    for (index, &word) in words.iter().enumerate() {
        if !Word(word).is_valid() {
            return Err(TreeError::Word { index, word });
        }
        if let Node::Inner(target) = Word(word).node()
            && (target % 8 != 1 || target as usize >= words.len())
        {
            return Err(TreeError::Index { index, target });
        }
    }
    let mut heights = vec![UNMET; words.len() / 8];
    let mut met = 0;
    let mut path: Vec<Step> = Vec::new();
    let mut enter = |block: usize, path: &mut Vec<Step>, heights: &mut [u8]| {
        if block != 1 + 8 * met {
            return Err(TreeError::Order { block });
        }
        if path.len() as u32 + 1 >= depth {
            return Err(TreeError::TooDeep { block, depth });
        }
        let uniform = |&w: &u32| matches!(Word(w).node(), Node::Uniform(_));
        if words[block..block + 8].iter().all(uniform) {
            return Err(TreeError::NotMerged { block });
        }
        met += 1;
        heights[block / 8] = OPEN;
        path.push(Step { block, next: 0, height: 0 });
        Ok(())
    };
    if let Node::Inner(block) = Word(words[0]).node() {
        enter(block as usize, &mut path, &mut heights)?;
    }
    loop {
        let open = path.len() as u32;
        let Some(step) = path.last_mut() else { break };
        let Step { block, next, height } = *step;
        if next == 8 {
            path.pop();
            heights[block / 8] = height + 1;
            if let Some(above) = path.last_mut() {
                above.height = above.height.max(height + 1);
            }
            continue;
        }
        step.next += 1;
        match Word(words[block + next]).node() {
            Node::Uniform(_) => {}
            Node::Mask(_) => step.height = step.height.max(1),
            Node::Inner(below) => match heights[below as usize / 8] {
                UNMET => enter(below as usize, &mut path, &mut heights)?,
                known => {
                    // A block that the walk is in lies below itself.
                    let too_deep = known == OPEN || open + u32::from(known) > depth;
                    if too_deep {
                        return Err(TreeError::TooDeep { block: below as usize, depth });
                    }
                    step.height = step.height.max(known);
                }
            },
        }
    }
    if 1 + 8 * met != words.len() {
        return Err(TreeError::Order { block: 1 + 8 * met });
    }
    Ok(())
}
