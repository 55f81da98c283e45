//! Reduces a tree to a graph: equal subtrees are stored once. Source: the paper's §3.2.
//!
//! [`sort`] takes a whole tree and merges equal blocks height by height. [`Interned`] and
//! [`tree_hash::TreeHashed`] receive blocks while a builder produces them and never hold a subtree twice. All
//! three compare contents in full, so all three give the same graph once it is numbered.

mod hash;
mod sort;
pub mod tree_hash;

pub use hash::Interned;
pub use sort::sort;

use crate::tree::blocks::MAX_BLOCKS;
use crate::tree::error::{Error, Result};
use crate::tree::word::{Node, Word};

/// Receives the blocks of a builder.
pub trait Sink {
    /// Adds a block, whose children have already been added, and returns the word of its parent.
    ///
    /// # Errors
    /// Returns [`adumbra_bake::Error::TooManyWords`] if 31 bits cannot address the block.
    fn block(&mut self, words: &[Word; 8]) -> Result<Word>;

    /// Number of bytes held.
    fn memory_bytes(&self) -> u64;
}

/// Keeps every block, in the order received: the whole tree.
impl Sink for Vec<[Word; 8]> {
    fn block(&mut self, words: &[Word; 8]) -> Result<Word> {
        let word = next_word(self.len())?;
        self.push(*words);
        Ok(word)
    }

    fn memory_bytes(&self) -> u64 {
        (self.capacity() * size_of::<[Word; 8]>()) as u64
    }
}

/// Returns the word of the block that comes after `count` others.
fn next_word(count: usize) -> Result<Word> {
    if count >= MAX_BLOCKS {
        return Err(Error::too_many_words("the tree"));
    }
    Ok(Word::new(Node::Inner(count as u32)))
}
