//! Finds blocks of one height that resemble each other. They are sorted several times, each time with another
//! part of them as the least significant bits, so that blocks that differ only in that part become
//! neighbours. Each block is compared with the next few.
//!
//! The *image* of a block is 64 bits, one per grandchild: whether it is lit, or mostly lit. A block of leaves
//! is identical to its image.

use rayon::prelude::*;

use crate::tree::lossy::candidate::Candidate;
use crate::tree::lossy::facts::{Facts, LIT_ERROR, lit};
use crate::tree::lossy::nearest::{Nearest, Offer};
use crate::tree::word::{Node, Word};
use adumbra_scene::random::mix;

/// Number of neighbours in sorted order that a block is compared with.
const WINDOW: usize = 8;
/// Maximum number of differing bits between the images of two blocks of blocks for their voxels to be
/// compared.
const IMAGE_BITS: u32 = 8;
/// Number of blocks in a piece, which one thread processes.
const PART: usize = 1 << 11;
/// Number of pieces processed before their offers are kept; bounds the memory for the offers.
const BATCH: usize = 1 << 5;

/// A block with its sort key.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    key: u64,
    block: u32,
    /// Maximum number of changed cells, in cells of this height: 8^(level - lowest level) voxels each. 0 for
    /// a block that must stay.
    may_change: u32,
}

/// Returns pairs of similar blocks among the blocks from `first` on, all of `height` (0 = blocks of leaves).
/// The source of a pair occurs once, and replacing it costs at most `limit` quarters of a voxel per block
/// saved, and at most `left` voxels in total.
pub(crate) fn find(
    blocks: &[[Word; 8]],
    facts: &[Facts],
    first: usize,
    height: u32,
    (limit, left): (u64, u64),
) -> Vec<Candidate> {
    let lowest_level = height + 2;
    let cell_bits = |f: &Facts| 3 * (u32::from(f.level) - lowest_level);
    let may_change = |f: &Facts| match f.single {
        true => ((limit * u64::from(f.saved) / 4).min(left) >> cell_bits(f)).min(u64::from(u32::MAX)) as u32,
        false => 0,
    };
    let mut entries: Vec<Entry> = (first as u32..)
        .zip(&facts[first..])
        .map(|(block, f)| Entry { key: 0, block, may_change: may_change(f) })
        .collect();
    if entries.iter().all(|e| e.may_change == 0) {
        return Vec::new();
    }
    let images: Vec<u64> = blocks[first..].par_iter().map(|words| image(words, blocks, facts)).collect();
    let image = |block: u32| images[block as usize - first];
    let mut nearest = Nearest::new(first, entries.len());
    if height == 0 {
        for last in (0..8).flat_map(|a| (a + 1..8).map(move |b| [a, b])) {
            let key = |block: u32| with_last(image(block), last);
            compare(&mut entries, &mut nearest, key, |x, y, _| u64::from((x.key ^ y.key).count_ones()));
        }
    } else {
        let voxels = |x: &Entry, y: &Entry, at_most| {
            let [x, y] = [x, y].map(|e| Word::new(Node::Inner(e.block)));
            difference(blocks, facts, [x, y], lowest_level, at_most)
        };
        for slot in 0..8 {
            let others = |block: u32| {
                let words = &blocks[block as usize];
                (0..8).filter(|i| *i != slot).fold(0, |h, i| mix(h ^ u64::from(words[i].0)))
            };
            compare(&mut entries, &mut nearest, others, |x, y, at_most| match x.key == y.key {
                true => voxels(x, y, at_most),
                false => u64::MAX,
            });
        }
        // More rotations find almost no further pairs.
        for turn in [0, 32] {
            let key = |block: u32| image(block).rotate_left(turn);
            compare(&mut entries, &mut nearest, key, |x, y, at_most| match (x.key ^ y.key).count_ones() {
                ..=IMAGE_BITS => voxels(x, y, at_most),
                _ => u64::MAX,
            });
        }
    }
    nearest.candidates(|source, cells| cells << cell_bits(&facts[source as usize]))
}

/// Sorts by `key`, and offers each block the next few, at a distance of `cells`. `cells` may stop counting
/// once it exceeds the number it receives.
fn compare(
    entries: &mut [Entry],
    nearest: &mut Nearest,
    key: impl Fn(u32) -> u64 + Sync,
    cells: impl Fn(&Entry, &Entry, u64) -> u64 + Sync,
) {
    entries.par_iter_mut().for_each(|e| {
        e.key = key(e.block);
        if e.may_change > 0 {
            // An offer no better than the targets that a block already has is useless.
            e.may_change = e.may_change.min(nearest.useful(e.block));
        }
    });
    entries.par_sort_unstable();
    let offers_of = |part: usize| {
        let mut offers = Vec::new();
        for (i, x) in (0..entries.len()).zip(&*entries).skip(part * PART).take(PART) {
            for y in entries[i + 1..].iter().take(WINDOW) {
                let at_most = x.may_change.max(y.may_change);
                if at_most == 0 {
                    continue;
                }
                let apart = cells(x, y, u64::from(at_most));
                for (source, target) in [(x, y), (y, x)] {
                    if apart <= u64::from(source.may_change) {
                        offers.push(Offer {
                            source: source.block,
                            target: target.block,
                            cells: apart as u32,
                        });
                    }
                }
            }
        }
        offers
    };
    for batch in (0..entries.len().div_ceil(PART)).step_by(BATCH) {
        let offers: Vec<Vec<Offer>> = (batch..batch + BATCH).into_par_iter().map(offers_of).collect();
        offers.into_iter().flatten().for_each(|offer| nearest.take(offer));
    }
}

/// Returns `bits` with two of its bytes moved to the least significant end.
fn with_last(bits: u64, [a, b]: [u32; 2]) -> u64 {
    let byte = |i: u32| bits >> (8 * i) & 255;
    let rest = (0..8).filter(|i| *i != a && *i != b).fold(0, |key, i| key << 8 | byte(i));
    rest << 16 | byte(a) << 8 | byte(b)
}

fn image(words: &[Word; 8], blocks: &[[Word; 8]], facts: &[Facts]) -> u64 {
    let mostly_lit = |word: Word| lit(word, facts) >= 1 << 31;
    words.iter().fold(0, |image, word| {
        let byte = match word.node() {
            Node::Inner(block) => {
                (0..8).fold(0, |bits, c| bits | u8::from(mostly_lit(blocks[block as usize][c])) << c)
            }
            Node::Mask(_) | Node::Uniform(_) => mask(*word),
        };
        image << 8 | u64::from(byte)
    })
}

/// Returns the number of voxels in which two nodes of the same level differ, or some number above `at_most`
/// if it is higher.
pub(crate) fn difference(
    blocks: &[[Word; 8]],
    facts: &[Facts],
    [a, b]: [Word; 2],
    level: u32,
    at_most: u64,
) -> u64 {
    if a == b {
        return 0;
    }
    let ((Node::Inner(_), _) | (_, Node::Inner(_))) = (a.node(), b.node()) else {
        return u64::from((mask(a) ^ mask(b)).count_ones()) << (3 * (level - 1));
    };
    let child = |w: Word, c: usize| match w.node() {
        Node::Inner(block) => blocks[block as usize][c],
        Node::Mask(bits) => Word::new(Node::Uniform(bits >> c & 1 == 1)),
        Node::Uniform(_) => w,
    };
    let pairs: [[Word; 2]; 8] = std::array::from_fn(|c| [child(a, c), child(b, c)]);
    // Children differ by at least the difference of their lit voxel counts, which is enough to reject most
    // pairs.
    let at_least = |[a, b]: &[Word; 2]| {
        let apart = lit(*a, facts).abs_diff(lit(*b, facts)).saturating_sub(LIT_ERROR);
        (u128::from(apart) << (3 * (level - 1)) >> 32) as u64
    };
    let mut sum = pairs.iter().map(at_least).sum();
    if sum > at_most {
        return sum;
    }
    for pair in &pairs {
        let rest = sum - at_least(pair);
        sum = rest + difference(blocks, facts, *pair, level - 1, at_most - rest);
        if sum > at_most {
            break;
        }
    }
    sum
}

/// Returns the bits of a leaf.
fn mask(word: Word) -> u8 {
    match word.node() {
        Node::Mask(bits) => bits,
        Node::Uniform(true) => 255,
        Node::Uniform(false) | Node::Inner(_) => 0,
    }
}
