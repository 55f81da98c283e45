//! From tree to graph: equal subtrees are stored once. Source: the paper's §3.2.
//!
//! [`sort`] takes a whole tree and merges equal blocks height by height; [`Interned`] and [`tree_hash::TreeHashed`] are given
//! blocks while a builder makes them and never hold a subtree twice. All three compare contents in full, so all three
//! give the same graph once it is numbered.

mod hash;
mod sort;
pub mod tree_hash;

pub use hash::Interned;
pub use sort::sort;

use super::blocks::MAX_BLOCKS;
use super::word::{Node, Word};
use crate::error::{Error, Result};

/// Where a builder's blocks go.
pub trait Sink {
    /// Takes a block, children already taken, and gives the word of its parent.
    ///
    /// # Errors
    /// [`Error::MemoryLimit`] where 31 bits do not reach further.
    fn block(&mut self, words: &[Word; 8]) -> Result<Word>;

    /// Bytes held.
    fn memory_bytes(&self) -> u64;
}

/// Every block as it comes: the tree itself.
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

/// The word of the block that comes after `count` others.
fn next_word(count: usize) -> Result<Word> {
    if count >= MAX_BLOCKS {
        let limit_bytes = (MAX_BLOCKS * 32) as u64;
        let what = "a tree of more than 2^28 blocks; lower --resolution";
        return Err(Error::MemoryLimit { what, needed_bytes: limit_bytes + 32, limit_bytes });
    }
    Ok(Word::new(Node::Inner(count as u32)))
}
