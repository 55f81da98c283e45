//! Leaf masks of the product's quadtree.

use adumbra::layout::depths::DepthTree;
use adumbra::layout::depths::code::{Code, ColumnNode};
use adumbra::layout::depths::leaf::LeafHead;
use adumbra::layout::depths::slant::{SLANT_BITS, Slant};

use crate::dag::LeafMasks;

/// Largest rise of a column of any leaf, in voxels.
const MAX_RISE: u32 = (2 * 7 * 128) >> SLANT_BITS;

/// Number of fraction bits of the reciprocal of a gradient.
const RECIPROCAL_BITS: u32 = 20;

impl LeafMasks for DepthTree {
    fn size(&self) -> [u32; 3] {
        self.size()
    }

    /// Cost: one step per two levels above 3, then one step per depth of the leaf.
    fn look_up(&self, i: u32, j: u32, k: u32) -> u64 {
        match self.place(i, j).0 {
            ColumnNode::Uniform(value) if k < value => u64::MAX,
            ColumnNode::Uniform(_) => 0,
            ColumnNode::Leaf { at, base } => leaf_mask(self.shapes(), at, base, k),
        }
    }

    fn end_level(&self, i: u32, j: u32, _k: u32) -> u32 {
        match self.place(i, j) {
            (ColumnNode::Uniform(_), level) => level,
            (ColumnNode::Leaf { .. }, _) => 0,
        }
    }
}

/// Returns the columns of a leaf that are lit at depth k.
#[inline]
fn leaf_mask(code: Code<'_>, at: u32, base: u32, k: u32) -> u64 {
    let half = |at| code.half(at);
    let head = LeafHead::new(half(at));
    let slant = if head.slanted { Slant::from_half(half(at + 1)) } else { Slant::default() };
    let largest_rise = slant.largest_rise();
    let plane_of = |rank: u32, p: u32| {
        let plane = head.plane(at, p, half);
        if rank >> p & 1 == 1 { plane } else { !plane }
    };
    // Number of ranks whose columns are all shadowed, and the shadowed columns of other ranks.
    let (mut shadowed_ranks, mut dark) = (0, 0);
    let mut depth = base;
    for rank in 0..=head.differences() {
        if rank > 0 {
            depth = depth.saturating_add(head.difference(at, rank - 1, half));
        }
        if k.saturating_add(largest_rise) < depth {
            break;
        }
        if depth <= k {
            shadowed_ranks += 1;
        } else {
            let of_rank = (0..head.planes()).fold(u64::MAX, |mask, p| mask & plane_of(rank, p));
            dark |= of_rank & !columns_below(slant, depth - k);
        }
    }
    !dark & code.leaf(at, base).at_least(shadowed_ranks)
}

/// Returns the columns of a slanted leaf that rise by less than `rise`, which must be at least 1. In every
/// row they begin at the deepest column.
fn columns_below(slant: Slant, rise: u32) -> u64 {
    let [x, y] = [slant.x, slant.y].map(|g| i32::from(g.unsigned_abs()));
    // The largest rise that is below the limit, in quarters.
    let most = ((rise - 1).min(MAX_RISE) << SLANT_BITS) as i32;
    if x == 0 {
        // Whole rows, as over level ground.
        let rows = if y == 0 { 8 } else { (most / y + 1).min(8) };
        return if slant.y > 0 { u64::MAX << (64 - 8 * rows) } else { u64::MAX >> (64 - 8 * rows) };
    }
    // One division instead of eight. `inverse` exceeds 2^20 / x by at most 1, so `left * inverse / 2^20`
    // exceeds `left / x` by at most `left / 2^20`. The floors are equal if that is less than 1 / x, which
    // holds because left * x <= 7 * 128 * 128 < 2^20.
    let inverse = (1 << RECIPROCAL_BITS) / x + 1;
    (0..8).fold(0, |mask, row| {
        let left = most - y * if slant.y > 0 { 7 - row } else { row };
        let columns = match left {
            ..0 => 0,
            _ => ((left.min(7 * x) * inverse) >> RECIPROCAL_BITS) + 1,
        };
        let bits = if slant.x > 0 { 0xff << (8 - columns) & 0xff } else { (1 << columns) - 1 };
        mask | u64::from(bits as u8) << (8 * row)
    })
}

#[cfg(test)]
mod tests {
    use adumbra_scene::random::Random;
    use adumbra_testing::{BASES, Leaf, every_gradient, from_leaves, random_leaves};

    use super::*;

    #[test]
    fn columns_below_any_rise_are_found_for_every_gradient() {
        let slant = Slant { x: 8, y: -4 };
        assert_eq!((columns_below(slant, 22), columns_below(slant, 1)), (u64::MAX, 1 << 7));
        for half in 0..=u32::from(u16::MAX) {
            let slant = Slant::from_half(half);
            let largest = slant.largest_rise();
            let mut of_rise = [0_u64; MAX_RISE as usize + 1];
            (0..64).for_each(|column| of_rise[slant.rise(column) as usize] |= 1 << column);
            let mut below = 0;
            for rise in 1..=largest + 1 {
                below |= of_rise[rise as usize - 1];
                assert_eq!(columns_below(slant, rise), below, "{slant:?} {rise}");
            }
            assert_eq!([columns_below(slant, u32::MAX), below], [u64::MAX; 2], "{slant:?}");
        }
    }

    /// Compares the leaf masks of the leaf at a column, in these layers, with the columns' depths.
    fn check_leaf(found: &DepthTree, [i, j]: [u32; 2], layers: std::ops::Range<u32>) {
        let depths: [u32; 64] = std::array::from_fn(|c| found.value(i + c as u32 % 8, j + c as u32 / 8));
        for k in layers {
            let expected =
                depths.iter().enumerate().fold(0, |mask, (at, &depth)| mask | u64::from(k < depth) << at);
            assert_eq!(found.look_up(i, j, k), expected, "({i}, {j}, {k}): {depths:?}");
        }
    }

    #[test]
    fn leaf_masks_match_depths_for_every_gradient() {
        let base = 452;
        let leaves = every_gradient();
        let found = from_leaves(&leaves, 256, base, 1024).unwrap();
        for (at, leaf) in leaves.iter().enumerate() {
            let nearest = (0..64).filter_map(|c| leaf.depth(base, c)).min().unwrap();
            check_leaf(&found, [at % 256, at / 256].map(|c| 8 * c as u32), nearest - 2..base + 2);
        }
    }

    /// Returns the layers in which a depth matters, in a grid of the greatest length.
    fn layers_about(depth: u32) -> std::ops::Range<u32> {
        depth.saturating_sub(460)..depth.saturating_add(3).min(u32::MAX - 1)
    }

    #[test]
    fn leaf_masks_match_depths_for_any_ranks_and_bases() {
        let mut random = Random::for_batch(7, 0);
        for case in 0..400 {
            let leaves = random_leaves(&mut random, case);
            let base = BASES[case % BASES.len()];
            let found = from_leaves(&leaves, 4, base, u32::MAX).unwrap();
            for (at, leaf) in leaves.iter().enumerate() {
                let corner = [at % 4, at / 4].map(|c| 8 * c as u32);
                check_leaf(&found, corner, layers_about(base));
                if let Some(depth) = leaf.depth(base, 5 * (case + at) % 64) {
                    check_leaf(&found, corner, layers_about(depth));
                }
            }
        }
    }

    #[test]
    fn leaf_masks_of_one_row_match_the_worked_example() {
        let ranks = (0..64).map(|column| u32::from(column >= 8)).collect();
        let leaf = Leaf { width: 1, never: true, ranks, ..Leaf::default() };
        let found = from_leaves(&vec![leaf; 16], 4, 7, 64).unwrap();
        assert_eq!((found.look_up(0, 0, 6), found.look_up(0, 0, 7)), (u64::MAX, !0xff));
    }
}
