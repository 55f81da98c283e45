//! Chooses where columns switch from lit to shadowed within their intervals. Masks are kept as long as
//! possible, and depths are rounded. This makes curtains long, and lets neighbours and upper levels agree.

use crate::dag::roots::LEAF_NODE_LEVEL;
use adumbra_bake::structure::{BlockColumns, FREE_TO_END};

/// log2 of the multiple to which depths are rounded up behind the last surface of a column whose end is free.
/// The shadow still begins close behind the surface, for objects that move there.
const FREE_ROUND_LEVEL: u32 = 6;

/// Beyond every layer of a grid.
pub(super) const FOREVER: u32 = u32::MAX;

/// Emits the leaf masks of an 8 × 8 block in a grid `depth` voxels deep, cube by cube of eight layers.
/// `visit(end, masks)` covers all cubes from the end of the previous call up to `end`, which all have these
/// eight leaf masks, bit y·8 + x, 1 = lit. The end of the last call is [`FOREVER`].
///
/// Everything is lit until a column must be shadowed. From there on a mask is kept as long as allowed while
/// first surfaces are crossed. Where no first surface is crossed, the mask has only the columns that must be
/// lit: the outline of the surfaces still to come.
pub(super) fn for_each_cube(columns: &BlockColumns, depth: u32, mut visit: impl FnMut(u32, [u64; 8])) {
    let latest = columns.e.iter().fold(0, |m, &e| m.max(e));
    let forced = columns.x.iter().fold(FOREVER, |m, &x| m.min(x));
    if latest <= forced {
        return switch_all(roundest(latest, forced), depth, visit);
    }
    let mut next_cube = forced >> LEAF_NODE_LEVEL;
    if next_cube > 0 {
        visit(next_cube, [u64::MAX; 8]);
    }
    let mut mask = u64::MAX;
    for cube in cubes_of_ends(columns, forced) {
        if cube > next_cube {
            mask = must_be_lit(columns, next_cube << LEAF_NODE_LEVEL);
            visit(cube, [mask; 8]);
            next_cube = cube;
        }
        let z = cube << LEAF_NODE_LEVEL;
        let lit_at_start = must_be_lit(columns, z);
        if lit_at_start == 0 || z >= depth {
            break;
        }
        if mask != u64::MAX && lit_at_start == must_be_lit(columns, z + 7) {
            mask = lit_at_start;
        }
        let leaf_masks = std::array::from_fn(|layer| {
            let k = z + layer as u32;
            if mask & must_be_shadowed(columns, k) != 0 {
                mask = must_be_lit(columns, k);
            }
            mask
        });
        next_cube = cube + 1;
        visit(next_cube, leaf_masks);
    }
    // No look-up reaches behind the grid's end, so columns that are lit at the end stay lit.
    let last = (next_cube << LEAF_NODE_LEVEL).min(depth - 1);
    visit(FOREVER, [must_be_lit(columns, last); 8]);
}

/// Emits the masks of a block whose columns all switch at `switch`.
fn switch_all(switch: u32, depth: u32, mut visit: impl FnMut(u32, [u64; 8])) {
    if switch >= depth {
        return visit(FOREVER, [u64::MAX; 8]);
    }
    let (cube, layer) = (switch >> LEAF_NODE_LEVEL, switch & 7);
    if cube > 0 {
        visit(cube, [u64::MAX; 8]);
    }
    if layer > 0 {
        visit(cube + 1, std::array::from_fn(|k| if (k as u32) < layer { u64::MAX } else { 0 }));
    }
    visit(FOREVER, [0; 8]);
}

/// Returns the cubes that contain the e or x of a column, at `forced` or deeper, nearest first.
fn cubes_of_ends(columns: &BlockColumns, forced: u32) -> Vec<u32> {
    let mut cubes: Vec<u32> = Vec::with_capacity(16);
    for &end in columns.e.iter().chain(&columns.x) {
        let cube = end >> LEAF_NODE_LEVEL;
        if end >= forced && end < FREE_TO_END && !cubes.contains(&cube) {
            cubes.push(cube);
        }
    }
    cubes.sort_unstable();
    cubes
}

/// Returns the number in `[start, end]` that is a multiple of the highest power of two. If the end is free,
/// returns the first multiple of 2^[`FREE_ROUND_LEVEL`] from `start` on.
pub(super) fn roundest(start: u32, end: u32) -> u32 {
    if end >= FREE_TO_END {
        return start.checked_next_multiple_of(1 << FREE_ROUND_LEVEL).unwrap_or(start);
    }
    if start == 0 || start == end {
        return start;
    }
    // Below the highest bit in which start - 1 and end differ, the result can be all zeros.
    let differ = 31 - ((start - 1) ^ end).leading_zeros();
    end & !((1 << differ) - 1)
}

/// Returns the columns whose voxel k must be lit, bit y·8 + x.
fn must_be_lit(columns: &BlockColumns, k: u32) -> u64 {
    texels_where(|i| k < columns.e[i])
}

/// Returns the columns whose voxel k must be shadowed, bit y·8 + x.
fn must_be_shadowed(columns: &BlockColumns, k: u32) -> u64 {
    texels_where(|i| k >= columns.x[i])
}

fn texels_where(test: impl Fn(usize) -> bool) -> u64 {
    // First one byte per texel: compilers vectorize this, but not a loop that shifts single bits.
    let bytes: [u8; 64] = std::array::from_fn(|texel| u8::from(test(texel)));
    let (rows, _) = bytes.as_chunks();
    rows.iter().rev().fold(0, |mask, &row| {
        // The multiplication moves the low bit of byte c to bit c of the highest byte.
        mask << 8 | u64::from_le_bytes(row).wrapping_mul(0x0102_0408_1020_4080) >> 56
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn roundest_has_most_trailing_zeros() {
        for start in 0..200_u32 {
            for end in start..200 {
                let best = (start..=end).max_by_key(|n| n.trailing_zeros()).unwrap_or(start);
                assert_eq!(roundest(start, end).trailing_zeros(), best.trailing_zeros(), "{start} {end}");
                assert!((start..=end).contains(&roundest(start, end)));
            }
        }
        assert_eq!(roundest(65, FREE_TO_END), 128);
        assert_eq!(roundest(64, FREE_TO_END), 64);
    }

    proptest! {
        #[test]
        fn cubes_respect_interval_of_every_column(ends in prop::collection::vec((0_u32..300, 0_u32..90), 64), depth in 1_u32..320) {
            let mut columns = BlockColumns::free();
            for (i, (e, length)) in ends.into_iter().enumerate() {
                columns.e[i] = e.min(depth);
                columns.x[i] = if length > 80 { FREE_TO_END } else { columns.e[i] + length };
            }
            let (mut from, mut before) = (0, u64::MAX);
            for_each_cube(&columns, depth, |end, leaf_masks| {
                assert!(end > from);
                // Long runs repeat, so checking two cubes of each is enough.
                for cube in from..end.min(from + 2).max(end.min(40)) {
                    for (k, mask) in (cube * 8..).zip(leaf_masks).filter(|(k, _)| *k < depth) {
                        assert_eq!(must_be_lit(&columns, k) & !mask, 0, "layer {k}");
                        assert_eq!(must_be_shadowed(&columns, k) & mask, 0, "layer {k}");
                        assert_eq!(mask & !before, 0, "layer {k} is lit behind shadow");
                        before = mask;
                    }
                }
                from = end;
            });
            prop_assert_eq!(from, FOREVER);
        }
    }
}
