//! The packed layout: the same graph as [`Dag`](crate::dag::plain::Dag), in about a third of the bytes.
//!
//! It relies on columns that are monotone along z: lit, then mixed, then shadowed. For two children or leaf
//! masks along z, one therefore implies part of the other, and half of the combinations never occur. Nodes
//! are strings of 16-bit *units*. A node with a single parent is stored inside that parent. All others are in
//! a *pool* of their level, the most referenced first, so that most pointers are short. Pointer widths chosen
//! by frequency and nodes inside their parents are known from geometry (Jaspe Villanueva, Marton, Gobbetti,
//! *SSVDAGs: Symmetry-aware Sparse Voxel DAGs*, 2016; Dado, Kol, Bauszat, Thiery, Eisemann, *Geometry and
//! Attribute Compression for Voxel Scenes*, 2016). The pairs along z, the runs of leaf masks and their bit
//! planes are specific to shadows. `docs/layouts.md` has the savings of each.
//!
//! **Top**, 32-bit words; c = gy · dims.x + gx, C = dims.x · dims.y:
//!
//! | word | meaning |
//! |---|---|
//! | i = 0 … 17 | base\[i\]: first unit of the pool of level 3 + i |
//! | 18 | number of units in use |
//! | 19 + 2c | first\[c\]: number of roots of columns before c |
//! | 20 + 2c | z0\[c\]: number of root cubes before the first that is not lit |
//! | 19 + 2C | first\[C\]: number of all roots |
//! | 20 + 2C + r | root r: unit relative to the pool of `root_level` |
//!
//! The root cubes of a column are lit before z0. From z0 on there is one root per cube, and behind the last
//! root the column is shadowed.
//!
//! **Node above level 3**, at unit a. A quarter q = (x_bit << 1) | y_bit has two children along z, the nearer
//! first:
//!
//! | bits of unit a | meaning |
//! |---|---|
//! | 3q+2 … 3q | code of quarter q |
//! | 14 … 12 | f: the pointer, 0 to 6, whose child directly follows the slots and which has no slot; 7: there is none |
//! | 15 | a string of high parts follows |
//!
//! The codes of a quarter are 0 both shadowed, 1 both lit, 2 lit then shadowed, 3 two mixed, 4 lit then
//! mixed, 5 mixed then shadowed, 6 one mixed node for both. Pointers are numbered through the quarters: one
//! each for codes 4, 5 and 6, two for code 3.
//!
//! The string of high parts is a bit string from unit a + 1 on, lowest bit first, padded to a whole unit.
//! Bits 0 to 7 are a mask of the wide pointers. The high parts follow from bit max(8, H) on, H bits each. H
//! is 4 if the pool of the level below has up to 2^20 units, 8 for up to 2^24, and 16 for more.
//!
//! The slots come next, one unit per pointer except f. A narrow slot below [`NEAR_UNITS`] is the child's
//! distance from the end of the slots. From [`NEAR_UNITS`] on, slot − [`NEAR_UNITS`] is the child's unit in
//! the pool of the level below. A wide slot is the lower 16 bits of the child's unit in that pool, and its
//! high part the bits above. The children without another parent follow the slots, f first, the others by
//! size.
//!
//! Worked value: unit 0x08C4 = `0_000_100_011_000_100` has f = 0, quarter 0 lit then mixed, 1 shadowed, 2 two
//! mixed, 3 lit then mixed. So it has four pointers and three slots. With the slots 0x0402, 0x0402, 0x0005,
//! pointers 1 and 2 lead to unit 2 of the pool, pointer 3 leads to five units behind the slots, and pointer 0
//! directly behind them.
//!
//! **Node of level 3**, at unit a:
//!
//! | bits of unit a | meaning |
//! |---|---|
//! | 7 … 0 | bit k: leaf mask z = k differs from the one before; the one before the first is all lit |
//! | 8 | the last change is to all shadowed |
//! | 14 … 9 | bit 9 + i: 1 mask i is inline, 0 it is an index into the shared masks; masks 5, 6, 7 share bit 14 |
//! | 15 | the masks are stored as bit planes |
//!
//! Inline masks of four units, lowest first, or indices of one unit, follow in the order of the leaf masks.
//! Each mask has a subset of the lit voxels of the one before, so d masks are equivalent to 64 counts from 0
//! to d: the number of masks in which each voxel is lit. Bit planes store these counts, four units per plane,
//! lowest bit first.
//!
//! Worked value: unit 0x0324 = `0_000001_1_00100100`: leaf masks 0 and 1 are lit, 2 to 4 are mask 0, which is
//! inline, and 5 to 7 are shadowed.

pub mod node;
#[cfg(test)]
mod tests;
mod validate;

pub use validate::PackedError;

use crate::dag::descend::{Descend, Descent};
use crate::dag::roots::{LEAF_NODE_LEVEL, MAX_ROOT_LEVEL};
use node::{NO_FOLLOWER, bits_below, high_bits, plane_count, pointers_in};

/// Narrow slots below this value are distances from the end of the node's slots.
pub const NEAR_UNITS: u32 = 1 << 10;
/// Number of words before the columns: the first unit of each level's pool, and the number of units in use.
pub const POOL_WORDS: usize = (MAX_ROOT_LEVEL - LEAF_NODE_LEVEL + 2) as usize;
/// Largest number of shared leaf masks: as many as a unit can index.
pub const MAX_SHARED_LEAF_MASKS: usize = 1 << 16;
/// Largest number of units: a pool's first unit and an index into a pool must each fit a signed word.
pub const MAX_UNITS: usize = 1 << 31;

/// A graph in the packed layout, which [`crate::dag::packed`] describes.
///
/// A look-up in a valid graph costs two or three units per level above 3, then two to sixteen units. Voxels
/// outside the top grid are lit.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PackedDag {
    /// Number of voxels along x, y, z in use. The top grid may cover a little more.
    pub size: [u32; 3],
    /// A root cube spans 2^root_level voxels along each side; 3 to [`MAX_ROOT_LEVEL`].
    pub root_level: u32,
    /// Number of root cubes along x, y, z: `ceil(size / 2^root_level)`.
    pub top_dims: [u32; 3],
    /// Pools, columns of root cubes, and roots.
    pub top: Vec<u32>,
    /// Nodes, one pool after the other from level 3 up. The number of units is even. The last is zero if it
    /// is not in use.
    pub units: Vec<u16>,
    /// Shared leaf masks, the most referenced first: bit y·8 + x, 1 = lit.
    pub leaf_masks: Vec<u64>,
}

impl PackedDag {
    fn four_units(&self, at: usize) -> u64 {
        self.units[at..at + 4].iter().rev().fold(0, |mask, &unit| mask << 16 | u64::from(unit))
    }

    /// Returns the first unit of a level's pool, which is the end of the pool of the level below.
    pub fn pool(&self, level: u32) -> u32 {
        self.top[(level - LEAF_NODE_LEVEL) as usize]
    }

    /// Returns the index of the first root in `top`.
    pub fn roots_at(&self) -> usize {
        POOL_WORDS + 2 * self.top_dims[0] as usize * self.top_dims[1] as usize + 1
    }
}

impl Descend for PackedDag {
    fn size(&self) -> [u32; 3] {
        self.size
    }

    fn root_level(&self) -> u32 {
        self.root_level
    }

    fn root(&self, i: u32, j: u32, k: u32) -> Descent {
        let [gx, gy, gz] = [i, j, k].map(|c| c >> self.root_level);
        if gx >= self.top_dims[0] || gy >= self.top_dims[1] || gz >= self.top_dims[2] {
            return Descent::Uniform(true);
        }
        let column = POOL_WORDS + 2 * (gy as usize * self.top_dims[0] as usize + gx as usize);
        let [first, z0, end] = [self.top[column], self.top[column + 1], self.top[column + 2]];
        if gz < z0 {
            return Descent::Uniform(true);
        }
        let root = first + (gz - z0);
        if root >= end {
            return Descent::Uniform(false);
        }
        Descent::Into(self.pool(self.root_level) + self.top[self.roots_at() + root as usize])
    }

    fn child(&self, at: u32, level: u32, i: u32, j: u32, k: u32) -> Descent {
        let bit = level - 1;
        let quarter = (i >> bit & 1) << 1 | j >> bit & 1;
        let far_half = k >> bit & 1 == 1;
        let unit = u32::from(self.units[at as usize]);
        let before = pointers_in(unit & bits_below(3 * quarter));
        let pointer = match (unit >> (3 * quarter) & 7, far_half) {
            (0, _) | (2 | 5, true) => return Descent::Uniform(false),
            (1, _) | (2 | 4, false) => return Descent::Uniform(true),
            (3, true) => before + 1,
            _ => before,
        };
        let follower = unit >> 12 & 7;
        let slots = pointers_in(unit & 0xfff) - u32::from(follower != NO_FOLLOWER);
        let mut slots_at = at + 1;
        let mut wide = 0;
        let mut high = 0;
        if unit >> 15 == 1 {
            let width = high_bits(self.pool(level) - self.pool(level - 1));
            wide = u32::from(self.units[at as usize + 1]) & 0xff;
            let front = width.max(8);
            slots_at += (front + width * wide.count_ones()).div_ceil(16);
            let place = front + width * (wide & bits_below(pointer)).count_ones();
            if wide >> pointer & 1 == 1 {
                high = u32::from(self.units[(at + 1 + (place >> 4)) as usize]) >> (place & 15)
                    & bits_below(width);
            }
        }
        // Pointer 7 is never the follower, because the value 7 of the field means that there is no follower.
        if pointer == follower && pointer != NO_FOLLOWER {
            return Descent::Into(slots_at + slots);
        }
        let slot = slots_at + pointer - u32::from(pointer > follower);
        let value = u32::from(self.units[slot as usize]);
        Descent::Into(if wide >> pointer & 1 == 1 {
            self.pool(level - 1) + (high << 16 | value)
        } else if value < NEAR_UNITS {
            slots_at + slots + value
        } else {
            self.pool(level - 1) + value - NEAR_UNITS
        })
    }

    fn leaf_mask_of_cube(&self, at: u32, k: u32) -> u64 {
        let unit = u32::from(self.units[at as usize]);
        let changes = (unit & 0xff).count_ones();
        let shadowed = unit >> 8 & 1;
        let change = (unit & bits_below(k + 1) & 0xff).count_ones();
        if change == 0 {
            return u64::MAX;
        }
        if change == changes && shadowed == 1 {
            return 0;
        }
        let mask = change - 1;
        let follow = at as usize + 1;
        if unit >> 15 == 1 {
            let planes = plane_count(changes - shadowed) as usize;
            return (0..planes).fold(u64::MAX, |lit, bit| {
                let plane = self.four_units(follow + 4 * bit);
                if change >> bit & 1 == 1 { lit & plane } else { lit | plane }
            });
        }
        let here = node::inline_masks(unit);
        let place = follow + (mask + 3 * (here & bits_below(mask)).count_ones()) as usize;
        if here >> mask & 1 == 1 {
            self.four_units(place)
        } else {
            self.leaf_masks[usize::from(self.units[place])]
        }
    }

    fn fill_of_cube(&self, at: u32, k: u32, leaf_masks: &mut [u64; 8]) -> u8 {
        let changes = u32::from(self.units[at as usize]) & 0xff;
        let leaf_mask = self.leaf_mask_of_cube(at, k);
        // All leaf masks from the last change at or before k up to the next change are equal.
        let from = (changes & bits_below(k + 1)).checked_ilog2().unwrap_or(0);
        let to = (changes >> k >> 1 | 1 << (7 - k)).trailing_zeros() + k + 1;
        leaf_masks[from as usize..to as usize].fill(leaf_mask);
        (bits_below(to) & !bits_below(from)) as u8
    }
}
