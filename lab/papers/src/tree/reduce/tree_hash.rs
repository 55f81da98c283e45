//! The paper's tree hash (3-5, 3-6): a subtree's hash from the hashes and sizes of its children.
//!
//! `hash = Σ c_i · prime[size_i mod max] · hash_i (mod m)`, `size = Σ size_i`. Chosen here: m = 2^61 - 1, a
//! prime; c_i, eight primes below 2^60 drawn at random, so that no two sums of few of them are equal; 1,021
//! table primes from 65,537 up; leaf hashes 1 (shadowed) and 2 (lit); leaf size 1 at any level. A leaf of
//! eight voxels counts as a node of eight leaves. Different subtrees may have the same hash. Subtrees are
//! merged only if their contents are equal, and every comparison that finds them different is counted as a
//! collision.

use hashbrown::HashTable;
use hashbrown::hash_table::Entry;

use crate::tree::blocks::Blocks;
use crate::tree::error::Result;
use crate::tree::reduce::{Sink, next_word};
use crate::tree::word::{Node, Word};
use adumbra_scene::random::mix;

/// The modulus m: hashes are from 0 to m - 1.
pub(crate) const MODULUS: u64 = (1 << 61) - 1;
/// c_i, one per child.
const CHILD_PRIMES: [u64; 8] = [
    0x039a_d4f6_3532_abaf,
    0x0c47_9c91_7774_8e83,
    0x0235_1b22_b971_eb09,
    0x054d_f1fe_4929_c23d,
    0x0260_4c24_6f9e_1a81,
    0x0fa1_faf2_b16a_5977,
    0x0f0b_67aa_4d70_0dfd,
    0x051e_bb89_8dfa_3041,
];
/// Length of the prime table, `max` in the formula.
const TABLE_PRIMES: usize = 1021;
/// Lower bound of the first prime in the table.
const FIRST_TABLE_PRIME: u64 = 65_537;
const SHADOWED_HASH: u64 = 1;
const LIT_HASH: u64 = 2;

/// Hash and size of a subtree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Sum {
    hash: u64,
    size: u64,
}

/// Blocks without duplicates, found by the tree hash.
pub struct TreeHashed {
    blocks: Vec<[Word; 8]>,
    sums: Vec<Sum>,
    table: HashTable<u32>,
    primes: Vec<u64>,
    modulus: u64,
    collisions: u64,
}

impl Default for TreeHashed {
    fn default() -> Self {
        Self::with_modulus(MODULUS)
    }
}

impl TreeHashed {
    /// Uses another m, from 2 to [`MODULUS`]; a small m collides often.
    pub(crate) fn with_modulus(modulus: u64) -> Self {
        Self {
            blocks: Vec::new(),
            sums: Vec::new(),
            table: HashTable::new(),
            primes: primes_from(FIRST_TABLE_PRIME, TABLE_PRIMES),
            modulus: modulus.clamp(2, MODULUS),
            collisions: 0,
        }
    }

    /// Number of comparisons of different subtrees with equal hashes.
    pub fn collisions(&self) -> u64 {
        self.collisions
    }

    /// Returns the graph below `root`.
    pub fn finish(self, root: Word) -> Blocks {
        Blocks { root, blocks: self.blocks }
    }

    fn sum(&self, word: Word) -> Sum {
        match word.node() {
            Node::Inner(block) => self.sums[block as usize],
            Node::Uniform(lit) => Sum { hash: if lit { LIT_HASH } else { SHADOWED_HASH }, size: 1 },
            Node::Mask(mask) => self.combine(|c| Sum {
                hash: if mask >> c & 1 == 1 { LIT_HASH } else { SHADOWED_HASH },
                size: 1,
            }),
        }
    }

    fn combine(&self, child: impl Fn(usize) -> Sum) -> Sum {
        let m = u128::from(self.modulus);
        (0..8).fold(Sum { hash: 0, size: 0 }, |sum, c| {
            let Sum { hash, size } = child(c);
            let prime = self.primes[(size % self.primes.len() as u64) as usize];
            let weight = u128::from(CHILD_PRIMES[c]) * u128::from(prime) % m;
            let term = weight * u128::from(hash) % m;
            Sum { hash: ((u128::from(sum.hash) + term) % m) as u64, size: sum.size.wrapping_add(size) }
        })
    }
}

impl Sink for TreeHashed {
    fn block(&mut self, words: &[Word; 8]) -> Result<Word> {
        let sum = self.combine(|c| self.sum(words[c]));
        let (blocks, sums, collisions) = (&self.blocks, &self.sums, &mut self.collisions);
        let same = |&i: &u32| {
            let equal = blocks[i as usize] == *words;
            *collisions += u64::from(!equal && sums[i as usize].hash == sum.hash);
            equal
        };
        // The table needs entropy in all 64 bits.
        match self.table.entry(mix(sum.hash), same, |&i| mix(sums[i as usize].hash)) {
            Entry::Occupied(found) => Ok(Word::new(Node::Inner(*found.get()))),
            Entry::Vacant(slot) => {
                let word = next_word(blocks.len())?;
                slot.insert(blocks.len() as u32);
                self.blocks.push(*words);
                self.sums.push(sum);
                Ok(word)
            }
        }
    }

    fn memory_bytes(&self) -> u64 {
        let lists = self.blocks.capacity() * size_of::<[Word; 8]>() + self.sums.capacity() * size_of::<Sum>();
        (lists + self.table.allocation_size() * 3 / 2) as u64
    }
}

/// Returns the first `count` primes from `first` up.
fn primes_from(first: u64, count: usize) -> Vec<u64> {
    (first..).filter(|&n| is_prime(n)).take(count).collect()
}

fn is_prime(n: u64) -> bool {
    n > 1 && (2..).take_while(|d| d * d <= n).all(|d| !n.is_multiple_of(d))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tree_hash_worked_value() {
        // Two of eight voxels lit: 2 · (c_0 + c_1) + c_2 + … + c_7, times the prime for size 1, which is the
        // second.
        let hashed = TreeHashed::default();
        let sum = hashed.sum(Word::leaf(0b11));
        assert_eq!(hashed.primes[1], 65_539);
        let c = CHILD_PRIMES.map(u128::from);
        let weights = c.iter().sum::<u128>() + c[0] + c[1];
        assert_eq!(u128::from(sum.hash), weights * 65_539 % u128::from(MODULUS));
        assert_eq!(sum.size, 8);
    }

    #[test]
    fn tree_hash_differs_for_all_masks() {
        let hashed = TreeHashed::default();
        let hashes: std::collections::HashSet<u64> =
            (1..255).map(|m| hashed.sum(Word::leaf(m)).hash).collect();
        assert_eq!(hashes.len(), 254);
    }
}
