//! Decodes the bytes to words.

use hashbrown::HashMap;

use crate::tree::error::Result;
use crate::tree::graph::VoxelTree;
use crate::tree::reduce::{Interned, Sink};
use crate::tree::symmetric::mirror::mirrored_mask;
use crate::tree::symmetric::node::Child;
use crate::tree::symmetric::{SymmetricTree, node};
use crate::tree::word::{Node, Word};

/// An image of a node, with the position of the walk in it.
struct WalkFrame {
    image: (u32, u8),
    next: u32,
    words: [Word; 8],
}

impl SymmetricTree {
    /// Converts the tree to words, reduced. If [`SymmetricTree::of`] made it from a reduced tree, the result
    /// is that tree. Cost: linear in the result.
    ///
    /// # Errors
    /// Returns [`adumbra_bake::Error::TooManyWords`] if the index of a word does not fit.
    pub fn to_tree(&self) -> Result<VoxelTree> {
        let mut blocks = Interned::default();
        // Finished images. Two images of a node may be equal; interning the blocks merges them.
        let mut done: HashMap<(u32, u8), Word> = HashMap::new();
        let mut path = Vec::new();
        let step = |at, mirror| WalkFrame { image: (at, mirror), next: 0, words: [Word::SHADOWED; 8] };
        let mut root = Word(node::word_at(&self.bytes, 4));
        if let Node::Inner(at) = root.node() {
            path.push(step(at, 0));
        }
        while let Some(WalkFrame { image: (at, mirror), next, words }) = path.last_mut() {
            if *next == 8 {
                let word = blocks.block(words)?;
                done.insert((*at, *mirror), word);
                path.pop();
                root = word;
                continue;
            }
            let from = *next ^ u32::from(*mirror);
            let word = match node::child_at(&self.bytes, self.mirrors, *at, from) {
                Child::Uniform(lit) => Word::new(Node::Uniform(lit)),
                Child::Mask(mask) => Word::leaf(mirrored_mask(mask, *mirror)),
                Child::Node { at, mirror: own } => {
                    let image = (at, own ^ *mirror);
                    match done.get(&image) {
                        Some(word) => *word,
                        None => {
                            path.push(step(image.0, image.1));
                            continue;
                        }
                    }
                }
            };
            words[*next as usize] = word;
            *next += 1;
        }
        Ok(blocks.finish(root).number(self.depth))
    }
}
