//! Blocks of one height that resemble each other: sorted several times with other parts of them last, so that blocks
//! which differ in those parts only come to stand side by side; each is then compared with the next few.

use rayon::prelude::*;

use super::choose::Candidate;
use super::round::{Facts, block_of};
use crate::dag::store::mix;
use crate::tree::word::{Node, Word};

/// Neighbours in sorted order that a block is compared with.
const WINDOW: usize = 8;
/// Most targets kept for a block.
const TARGETS: usize = 3;

/// A block as it is sorted.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    key: u64,
    block: u32,
    /// Voxels that it may cost; 0 for what must stay.
    may_cost: u32,
}

/// Pairs among the blocks from `first` on, all of one height, where the one stands in a single place and costs at most
/// `limit` voxels for each block that goes with it.
pub(super) fn find(blocks: &[[Word; 8]], facts: &[Facts], first: usize, limit: u64) -> Vec<Candidate> {
    let may_cost = |f: &Facts| limit.saturating_mul(u64::from(f.saved)).min(u64::from(u32::MAX)) as u32;
    let mut entries: Vec<Entry> = (first as u32..)
        .zip(&facts[first..])
        .map(|(block, f)| Entry { key: 0, block, may_cost: may_cost(f) })
        .collect();
    let mut nearest = Nearest { first, targets: vec![[NONE; TARGETS]; entries.len()] };
    if blocks[first].iter().all(|w| block_of(*w).is_none()) {
        of_leaves(blocks, facts, &mut entries, &mut nearest);
    } else {
        of_blocks(blocks, facts, &mut entries, &mut nearest);
    }
    nearest.candidates()
}

/// Blocks of leaves: 64 bits, so that the whole block is its key, with two bytes of it moved last.
fn of_leaves(blocks: &[[Word; 8]], facts: &[Facts], entries: &mut [Entry], nearest: &mut Nearest) {
    let bits = |block: u32| u64::from_be_bytes(blocks[block as usize].map(mask));
    // From voxels to cells.
    for e in entries.iter_mut().filter(|e| e.may_cost > 0) {
        let cell_level = u32::from(facts[e.block as usize].level) - 2;
        e.may_cost = e.may_cost.checked_shr(3 * cell_level).unwrap_or(0);
    }
    for a in 0..8 {
        for b in a + 1..8 {
            let last = |bits: u64| {
                let bytes = bits.to_be_bytes();
                let mut order = bytes;
                let mut n = 0;
                for (i, byte) in bytes.into_iter().enumerate() {
                    if i != a && i != b {
                        order[n] = byte;
                        n += 1;
                    }
                }
                (order[6], order[7]) = (bytes[a], bytes[b]);
                u64::from_be_bytes(order)
            };
            entries.par_iter_mut().for_each(|e| e.key = last(bits(e.block)));
            entries.par_sort_unstable();
            for (i, x) in entries.iter().enumerate() {
                for y in &entries[i + 1..(i + 1 + WINDOW).min(entries.len())] {
                    let cells = (x.key ^ y.key).count_ones();
                    for (source, target) in [(x, y), (y, x)] {
                        if cells <= source.may_cost {
                            let level = u32::from(facts[source.block as usize].level);
                            nearest.offer(source.block, target.block, cells << (3 * (level - 2)));
                        }
                    }
                }
            }
        }
    }
}

/// Blocks of blocks: the key is a hash of seven children.
fn of_blocks(blocks: &[[Word; 8]], facts: &[Facts], entries: &mut [Entry], nearest: &mut Nearest) {
    for slot in 0..8 {
        let key = |block: u32| {
            let others = blocks[block as usize].iter().enumerate().filter(|(i, _)| *i != slot);
            others.fold(0, |h, (_, w)| mix(h ^ u64::from(w.0)))
        };
        entries.par_iter_mut().for_each(|e| e.key = key(e.block));
        entries.par_sort_unstable();
        for (i, x) in entries.iter().enumerate() {
            for y in entries[i + 1..].iter().take(WINDOW).take_while(|y| y.key == x.key) {
                for (source, target) in [(x, y), (y, x)] {
                    if source.may_cost > 0 {
                        let level = u32::from(facts[source.block as usize].level);
                        let at_most = u64::from(source.may_cost);
                        let word = |e: &Entry| Word::new(Node::Inner(e.block));
                        let cost = difference(blocks, word(source), word(target), level, at_most);
                        if cost <= at_most {
                            nearest.offer(source.block, target.block, cost as u32);
                        }
                    }
                }
            }
        }
    }
}

/// Voxels in which two nodes of one level differ; something above `at_most` where they are more.
fn difference(blocks: &[[Word; 8]], a: Word, b: Word, level: u32, at_most: u64) -> u64 {
    if a == b {
        return 0;
    }
    match (a.node(), b.node()) {
        (Node::Uniform(_), Node::Uniform(_)) => 1 << (3 * level),
        (Node::Inner(_), _) | (_, Node::Inner(_)) => {
            let mut sum = 0;
            for c in 0..8 {
                let [a, b] = [a, b].map(|w| match w.node() {
                    Node::Inner(block) => blocks[block as usize][c],
                    Node::Mask(bits) => Word::new(Node::Uniform(bits >> c & 1 == 1)),
                    Node::Uniform(_) => w,
                });
                sum += difference(blocks, a, b, level - 1, at_most - sum);
                if sum > at_most {
                    break;
                }
            }
            sum
        }
        _ => u64::from((mask(a) ^ mask(b)).count_ones()) << (3 * (level - 1)),
    }
}

/// Bits of a leaf.
fn mask(word: Word) -> u8 {
    match word.node() {
        Node::Mask(bits) => bits,
        Node::Uniform(true) => 255,
        Node::Uniform(false) | Node::Inner(_) => 0,
    }
}

/// No target: dearer than any.
const NONE: (u32, u32) = (u32::MAX, u32::MAX);

/// The cheapest few targets of each block, as cost and block.
struct Nearest {
    first: usize,
    targets: Vec<[(u32, u32); TARGETS]>,
}

impl Nearest {
    fn offer(&mut self, source: u32, target: u32, cost: u32) {
        let targets = &mut self.targets[source as usize - self.first];
        let offered = (cost, target);
        if offered >= targets[TARGETS - 1] || targets.contains(&offered) {
            return;
        }
        let place = targets.partition_point(|t| *t < offered);
        targets[place..].rotate_right(1);
        targets[place] = offered;
    }

    fn candidates(self) -> Vec<Candidate> {
        let all = (self.first as u32..).zip(self.targets).flat_map(|(source, targets)| {
            targets.into_iter().filter(|t| *t != NONE).map(move |(cost, target)| Candidate {
                source,
                target,
                cost,
            })
        });
        all.collect()
    }
}
