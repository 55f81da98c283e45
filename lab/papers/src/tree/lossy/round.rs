//! One bottom-up walk. At each height, blocks are pointed to the replacements of their children, and equal
//! blocks are merged. Of the similar blocks, those that occur once are replaced if the cost is low enough.

use crate::tree::blocks::Blocks;
use crate::tree::error::Result;
use crate::tree::lossy::choose::choose;
use crate::tree::lossy::facts::{Facts, lit};
use crate::tree::lossy::similar;
use crate::tree::reduce::{Interned, Sink};
use crate::tree::word::Word;

/// The result of a round.
pub(crate) struct Round {
    pub(crate) blocks: Blocks,
    /// Number of blocks replaced by a similar one.
    pub(crate) merged: u64,
}

/// Merges at a cost of at most `limit` quarters of a voxel per block saved, and at most `budget` voxels in
/// total.
pub(crate) fn merge(graph: Blocks, depth: u32, limit: u64, budget: u64) -> Result<Round> {
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

/// In place of a level: the block occurs several times.
const SEVERAL: u8 = 255;

/// Returns the level of the node that each block belongs to, or [`SEVERAL`].
fn standing(root: Word, blocks: &[[Word; 8]], depth: u32) -> Vec<u8> {
    const UNVISITED: u8 = 254;
    let mut standing = vec![UNVISITED; blocks.len()];
    if let Some(block) = root.inner() {
        standing[block as usize] = depth as u8;
    }
    // Children precede their parents.
    for (b, words) in blocks.iter().enumerate().rev() {
        let below = if standing[b] == SEVERAL { SEVERAL } else { standing[b] - 1 };
        for child in words.iter().filter_map(|w| w.inner()) {
            let child = &mut standing[child as usize];
            *child = if *child == UNVISITED { below } else { SEVERAL };
        }
    }
    standing
}

/// Groups blocks by height: blocks of leaves only have height 0, others are one above their highest child.
/// Each group keeps the given order.
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
