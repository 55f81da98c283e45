//! Finds equal blocks by a hash of their words while the tree is built.

use hashbrown::HashTable;

use crate::tree::blocks::Blocks;
use crate::tree::error::Result;
use crate::tree::reduce::{Sink, next_word};
use crate::tree::word::{Node, Word};
use adumbra_scene::random::mix;

/// Blocks without duplicates.
#[derive(Default)]
pub struct Interned {
    blocks: Vec<[Word; 8]>,
    table: HashTable<u32>,
}

impl Interned {
    /// The blocks so far, in order of insertion.
    pub fn blocks(&self) -> &[[Word; 8]] {
        &self.blocks
    }

    /// Returns the graph below `root`.
    pub fn finish(self, root: Word) -> Blocks {
        Blocks { root, blocks: self.blocks }
    }
}

impl Sink for Interned {
    fn block(&mut self, words: &[Word; 8]) -> Result<Word> {
        let blocks = &self.blocks;
        let same = |&i: &u32| blocks[i as usize] == *words;
        let entry = self.table.entry(hash(words), same, |&i| hash(&blocks[i as usize]));
        match entry {
            hashbrown::hash_table::Entry::Occupied(found) => Ok(Word::new(Node::Inner(*found.get()))),
            hashbrown::hash_table::Entry::Vacant(slot) => {
                let word = next_word(blocks.len())?;
                slot.insert(blocks.len() as u32);
                self.blocks.push(*words);
                Ok(word)
            }
        }
    }

    fn memory_bytes(&self) -> u64 {
        // The peak size of the table, while it grows.
        (self.blocks.capacity() * size_of::<[Word; 8]>() + self.table.allocation_size() * 3 / 2) as u64
    }
}

fn hash(words: &[Word; 8]) -> u64 {
    words.as_chunks::<2>().0.iter().fold(0, |h, [a, b]| mix(h ^ (u64::from(a.0) << 32 | u64::from(b.0))))
}
