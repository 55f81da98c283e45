//! Reduces a whole tree to a graph by sorting, bottom up. Source: Kämpe, Sintorn, Assarsson 2013, as in the
//! paper's §3.2.1: the eight words of a block are one 256-bit key. Leaves of eight voxels are words in the
//! block of their parent, so they are not sorted separately. Departure: blocks are sorted by height above the
//! leaves, not by depth below the root, so equal subtrees at different depths merge too, as they do by hash.

use crate::tree::blocks::Blocks;
use crate::tree::word::Word;

/// Merges equal blocks of `tree`; also returns the peak number of bytes held. Cost: n log n; besides the
/// tree, a copy of the largest height, and one word and one byte per block.
pub fn sort(tree: Blocks) -> (Blocks, u64) {
    let Blocks { root, blocks: tree } = tree;
    let mut heights = vec![0_u8; tree.len()];
    let mut counts = Vec::new();
    for (b, words) in tree.iter().enumerate() {
        let below = words.iter().filter_map(|w| w.inner()).map(|child| heights[child as usize]);
        let height = 1 + below.max().unwrap_or(0);
        heights[b] = height;
        counts.resize(counts.len().max(usize::from(height)), 0);
        counts[usize::from(height) - 1] += 1;
    }
    let mut new_index = vec![0_u32; tree.len()];
    let mut merged: Vec<[Word; 8]> = Vec::new();
    for (height, &count) in (1_u8..).zip(&counts) {
        let mut keys: Vec<([Word; 8], u32)> = Vec::with_capacity(count);
        let of_height = (0..).zip(&heights).filter(|(_, h)| **h == height);
        let now = |child: u32| new_index[child as usize];
        keys.extend(of_height.map(|(b, _)| (tree[b as usize].map(|w| w.map_inner(now)), b)));
        keys.sort_unstable();
        for same in keys.chunk_by(|a, b| a.0 == b.0) {
            for (_, b) in same {
                new_index[*b as usize] = merged.len() as u32;
            }
            merged.push(same[0].0);
        }
    }
    let largest = counts.iter().copied().max().unwrap_or(0);
    let block = size_of::<[Word; 8]>();
    let held = tree.capacity() * block
        + tree.len() * 5
        + merged.capacity() * block
        + largest * size_of::<([Word; 8], u32)>();
    (Blocks { root: root.map_inner(|block| new_index[block as usize]), blocks: merged }, held as u64)
}
