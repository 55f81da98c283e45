//! A file's words as a shader reads them: its sections, one after the other.

use crate::layout::depths::DepthTree;

/// The 32-bit words of a file's voxels, in two consecutive parts: the blocks at which look-ups begin, two
/// words each; code, two half-words per word.
#[derive(Clone, Copy, Debug)]
pub struct Words<'f> {
    parts: [&'f [u32]; 2],
}

impl<'f> Words<'f> {
    /// Returns the words of a file's voxels, which are borrowed.
    pub(super) fn new(tree: &'f DepthTree) -> Self {
        Self { parts: [tree.top().as_flattened(), tree.code()] }
    }

    /// Returns both parts, in order.
    pub fn parts(&self) -> [&'f [u32]; 2] {
        self.parts
    }

    /// Returns all words, one part after the other.
    pub fn iter(&self) -> impl Iterator<Item = u32> {
        self.parts.into_iter().flatten().copied()
    }

    /// Returns all words in one piece. Cost: a copy.
    pub fn to_vec(self) -> Vec<u32> {
        self.parts.concat()
    }

    /// Returns the number of words.
    pub fn count(&self) -> u64 {
        self.parts.iter().map(|part| part.len() as u64).sum()
    }
}
