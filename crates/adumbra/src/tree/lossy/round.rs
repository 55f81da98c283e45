//! One walk from the lowest blocks up: at each height blocks are pointed to what became of their children, equal ones
//! become one, and of the similar ones those that stand in one place give way where it costs little enough.

use super::choose::choose;
use super::similar;
use crate::error::Result;
use crate::tree::blocks::Blocks;
use crate::tree::reduce::{Interned, Sink};
use crate::tree::word::{Node, Word};

/// What a round gives.
pub(super) struct Round {
    pub(super) blocks: Blocks,
    /// Blocks that gave way to a similar one.
    pub(super) merged: u64,
}

/// How much too low a share of lit voxels may be: exact up to level 10, above it each level rounds down.
pub(super) const LIT_ERROR: u64 = 4;

/// What is known of a block of the new graph.
#[derive(Clone, Copy)]
pub(super) struct Facts {
    /// It stands in one place.
    pub(super) single: bool,
    /// Level of the node that it belongs to, where it stands in one place.
    pub(super) level: u8,
    /// Blocks that go if it goes: itself and those below that stand in no other place.
    pub(super) saved: u32,
    /// Share of its voxels that are lit, of 2^32, less [`LIT_ERROR`] at most.
    pub(super) lit: u32,
}

impl Facts {
    /// It has come to stand in several places.
    fn stays(&mut self) {
        *self = Self { single: false, level: 0, saved: 0, lit: self.lit };
    }
}

/// Merges what costs at most `limit` quarters of a voxel for each block saved, and no more than `budget` voxels together.
pub(super) fn merge(graph: Blocks, depth: u32, limit: u64, budget: u64) -> Result<Round> {
    let Blocks { root, blocks: old } = graph;
    let standing = standing(root, &old, depth);
    let mut now = vec![0_u32; old.len()];
    let mut new = Interned::default();
    let mut facts: Vec<Facts> = Vec::new();
    let (mut merged, mut left) = (0, budget);
    for (height, members) in (0..).zip(by_height(&old)) {
        let first = facts.len();
        for &b in &members {
            let words = old[b as usize].map(|w| w.map_inner(|block| now[block as usize]));
            let word = new.block(&words)?;
            now[b as usize] = word.inner().unwrap_or_default();
            match facts.get_mut(now[b as usize] as usize) {
                Some(known) => known.stays(),
                None => {
                    let level = standing[b as usize];
                    let single = level != SEVERAL;
                    let below = words.iter().filter_map(|w| w.inner()).map(|c| facts[c as usize].saved);
                    let saved = if single { 1 + below.sum::<u32>() } else { 0 };
                    let lit = (words.iter().map(|w| lit(*w, &facts)).sum::<u64>() / 8) as u32;
                    facts.push(Facts { single, level: if single { level } else { 0 }, saved, lit });
                }
            }
        }
        if left == 0 {
            continue;
        }
        let candidates = similar::find(new.blocks(), &facts, first, height, (limit, left));
        let Some(chosen) = choose(candidates, &facts, first, &mut left) else { continue };
        merged += chosen.count;
        for &b in &members {
            let target = chosen.target[now[b as usize] as usize - first];
            if target != now[b as usize] {
                now[b as usize] = target;
                facts[target as usize].stays();
            }
        }
    }
    Ok(Round { blocks: new.finish(root.map_inner(|block| now[block as usize])), merged })
}

/// In place of a level: the block stands in several places.
const SEVERAL: u8 = 255;

/// Level of the node that each block belongs to, or [`SEVERAL`].
fn standing(root: Word, blocks: &[[Word; 8]], depth: u32) -> Vec<u8> {
    const UNMET: u8 = 254;
    let mut standing = vec![UNMET; blocks.len()];
    if let Some(block) = root.inner() {
        standing[block as usize] = depth as u8;
    }
    // Children stand before their parents.
    for (b, words) in blocks.iter().enumerate().rev() {
        let below = if standing[b] == SEVERAL { SEVERAL } else { standing[b] - 1 };
        for child in words.iter().filter_map(|w| w.inner()) {
            let child = &mut standing[child as usize];
            *child = if *child == UNMET { below } else { SEVERAL };
        }
    }
    standing
}

/// Share of a node's voxels that are lit, of 2^32.
pub(super) fn lit(word: Word, facts: &[Facts]) -> u64 {
    match word.node() {
        Node::Inner(block) => u64::from(facts[block as usize].lit),
        Node::Mask(bits) => u64::from(bits.count_ones()) << 29,
        Node::Uniform(lit) => u64::from(lit) << 32,
    }
}

/// Blocks by height: first those of leaves only, then those of these, and so on; each height in the order given.
fn by_height(blocks: &[[Word; 8]]) -> Vec<Vec<u32>> {
    let mut heights = vec![0_u8; blocks.len()];
    let mut lists: Vec<Vec<u32>> = Vec::new();
    for (b, words) in blocks.iter().enumerate() {
        let below = words.iter().filter_map(|w| w.inner()).map(|c| 1 + heights[c as usize]);
        heights[b] = below.max().unwrap_or(0);
        let height = usize::from(heights[b]);
        if lists.len() <= height {
            lists.push(Vec::new());
        }
        lists[height].push(b as u32);
    }
    lists
}
