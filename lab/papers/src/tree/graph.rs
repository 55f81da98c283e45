//! The paper's tree, or the graph that it reduces to, as 32-bit words.

use crate::tree::error::TreeError;
use crate::tree::morton;
use crate::tree::word::{MAX_DEPTH, Node, Word};

/// A cube with sides of 2^depth voxels as words: the root at word 0, then blocks of eight siblings. Child i
/// of an inner node is at its index plus i (3-7). Blocks are in pre-order of first visit, so a graph has
/// exactly one form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VoxelTree {
    pub(crate) depth: u32,
    pub(crate) words: Vec<u32>,
}

impl VoxelTree {
    /// Checks `words` and takes ownership of them. Cost: linear, one walk.
    ///
    /// # Errors
    /// Returns the first fault found, as a [`TreeError`].
    pub fn from_words(depth: u32, words: Vec<u32>) -> Result<Self, TreeError> {
        check(depth, &words)?;
        Ok(Self { depth, words })
    }

    /// Number of levels below the root.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Voxels along a side of the cube.
    pub fn side(&self) -> u32 {
        1 << self.depth
    }

    /// All words, root first.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Returns all words, root first, without a copy.
    pub fn into_words(self) -> Vec<u32> {
        self.words
    }

    /// Size of the words in bytes.
    pub fn bytes(&self) -> u64 {
        self.words.len() as u64 * 4
    }

    /// Decodes the node at a word index.
    pub fn node(&self, index: u32) -> Node {
        Word(self.words[index as usize]).node()
    }

    /// Returns the visibility of voxel (x, y, z), each coordinate below [`VoxelTree::side`]. Cost: at most
    /// one word per level.
    pub fn voxel(&self, xyz: [u32; 3]) -> bool {
        self.find(xyz).0
    }

    /// Returns the visibility of voxel (x, y, z) and the level of the cube that determines it: 0 = a single
    /// voxel.
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

/// Position of a walk within a block.
#[derive(Clone, Copy)]
struct WalkFrame {
    block: usize,
    next: usize,
    height: u8,
}

/// Checks that words are a tree in its canonical form. Cost: linear, one walk.
pub(crate) fn check(depth: u32, words: &[u32]) -> Result<(), TreeError> {
    /// In place of a height: the block has not been visited yet, or the walk is inside it.
    const UNVISITED: u8 = 0;
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
    let mut heights = vec![UNVISITED; words.len() / 8];
    let mut met = 0;
    let mut path: Vec<WalkFrame> = Vec::new();
    let mut enter = |block: usize, path: &mut Vec<WalkFrame>, heights: &mut [u8]| {
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
        path.push(WalkFrame { block, next: 0, height: 0 });
        Ok(())
    };
    if let Node::Inner(block) = Word(words[0]).node() {
        enter(block as usize, &mut path, &mut heights)?;
    }
    loop {
        let open = path.len() as u32;
        let Some(step) = path.last_mut() else { break };
        let WalkFrame { block, next, height } = *step;
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
                UNVISITED => enter(below as usize, &mut path, &mut heights)?,
                known => {
                    // A block that the walk is inside is its own descendant.
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
