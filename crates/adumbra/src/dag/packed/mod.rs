//! The packed layout: the same graph as [`Dag`](super::Dag), in about a third of the bytes.
//!
//! It rests on columns being monotone along z: lit, then mixed, then shadowed. What one of two children or slabs along z
//! says need not be said again, and half of the combinations never occur. Nodes are strings of 16-bit *units*; those with
//! one parent lie inside it, the others in a *pool* of their level, the most referenced first, so that most pointers are
//! short. Widths by frequency and nodes inside their parents are known from geometry (Jaspe Villanueva, Marton, Gobbetti,
//! *SSVDAGs: Symmetry-aware Sparse Voxel DAGs*, 2016; Dado, Kol, Bauszat, Thiery, Eisemann, *Geometry and Attribute
//! Compression for Voxel Scenes*, 2016); the pairs along z, the runs of slabs and their bit planes are for shadows.
//! `docs/layouts.md` has what each is worth.
//!
//! **Top**, 32-bit words; c = gy · dims.x + gx, C = dims.x · dims.y:
//!
//! | word | meaning |
//! |---|---|
//! | i = 0 … 17 | base\[i\]: unit where the pool of level 3 + i begins |
//! | 18 | units in use |
//! | 19 + 2c | first\[c\]: roots of columns before c |
//! | 20 + 2c | z0\[c\]: root cubes before the first that is not lit |
//! | 19 + 2C | first\[C\]: all roots |
//! | 20 + 2C + r | root r, unit counted from the pool of `root_level` |
//!
//! Root cube gz of a column is lit before z0, then comes a root each, then it is shadowed.
//!
//! **Node above level 3**, at unit a; a quarter q = (x_bit << 1) | y_bit has two children along z, the nearer first:
//!
//! | bits of unit a | meaning |
//! |---|---|
//! | 3q+2 … 3q | 0 both shadowed, 1 both lit, 2 lit then shadowed, 3 two mixed, 4 lit then mixed, 5 mixed then shadowed, 6 one mixed node for both |
//! | 14 … 12 | f: the pointer, 0 to 6, whose child follows the slots and which has no slot; 7: there is none |
//! | 15 | a string of high parts follows |
//!
//! Pointers are numbered through the quarters: one for 4, 5 and 6, two for 3. The high parts are bits from unit a + 1 on,
//! the lowest first, up to a whole unit: at bit 0, eight bits that say which pointers are wide; from bit max(8, H) on, H
//! bits each. H is 4, 8 or 16, as the pool of the level below has up to 2^20, up to 2^24, or more units. Then come the
//! slots, one unit a pointer but f. A narrow slot below [`NEAR_UNITS`] leads that far behind the end of the slots, from
//! there on it leads to that unit of the pool of the level below plus [`NEAR_UNITS`]; a wide one to that unit of the
//! pool, its high part above. Behind the slots lie the children with no other parent, f first, the others by size.
//!
//! Worked value: unit 0x08C4 = `0_000_100_011_000_100`, f = 0, quarter 0 lit then mixed, 1 shadowed, 2 two mixed, 3 lit
//! then mixed: four pointers, three slots. Slots 0x0402, 0x0402, 0x0005: pointers 1 and 2 lead to unit 2 of the pool, 3
//! to five units behind the slots, and 0 right behind them.
//!
//! **Node of level 3**, at unit a:
//!
//! | bits of unit a | meaning |
//! |---|---|
//! | 7 … 0 | bit k: slab z = k is not as the one before; before the first all is lit |
//! | 8 | the last change is to all shadowed |
//! | 14 … 9 | bit 9 + i: mask i stands here; 0: one unit, its place among the shared slabs. Masks 5, 6, 7 have bit 14 |
//! | 15 | planes stand here in place of masks |
//!
//! Masks of four units, the low first, or places of one unit, follow in the order of the slabs. As each loses voxels of
//! the one before, d masks are 64 counts from 0 to d, how many of them have the voxel lit: bit planes of four units, the
//! low bit's first.
//!
//! Worked value: unit 0x0324 = `0_000001_1_00100100`: slabs 0 and 1 lit, 2 to 4 mask 0, which stands here, 5 to 7 shadowed.

mod decode;
mod encode;
mod node;
#[cfg(test)]
mod tests;
mod validate;

pub use encode::PackError;
pub use validate::PackedError;

use super::trail::{Descend, Step, Trail};
use super::{MAX_ROOT_LEVEL, SLAB_NODE_LEVEL, Slabs};
use node::{NO_FOLLOWER, bits_below, high_bits, plane_count, pointers_in};

/// Narrow slots below this count from the end of the node's slots.
pub const NEAR_UNITS: u32 = 1 << 10;
/// Words in front of the columns: where each level's pool begins, and the units in use.
pub const POOL_WORDS: usize = (MAX_ROOT_LEVEL - SLAB_NODE_LEVEL + 2) as usize;
/// Most slabs that are shared: as many as a unit can name.
pub const MAX_SHARED_SLABS: usize = 1 << 16;
/// Most units: a pool's place and a place in it must fit a word and its sign.
pub const MAX_UNITS: usize = 1 << 31;

/// A graph in the packed layout; see the module's text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PackedDag {
    /// Voxels along x, y, z that mean anything.
    pub size: [u32; 3],
    /// A root cube spans 2^root_level voxels a side; 3 to [`MAX_ROOT_LEVEL`].
    pub root_level: u32,
    /// Root cubes along x, y, z: `ceil(size / 2^root_level)`.
    pub top_dims: [u32; 3],
    /// Pools, columns of root cubes, roots.
    pub top: Vec<u32>,
    /// Nodes, pool by pool from level 3 up; an even number of units, the last zero where it is not in use.
    pub units: Vec<u16>,
    /// Shared slabs, the most referenced first: bit y·8 + x, 1 = lit.
    pub slabs: Vec<u64>,
}

impl PackedDag {
    /// Visibility of the voxel (i, j, k); outside the top grid it is lit.
    ///
    /// Cost: two or three units a level above 3, then two to sixteen. The graph must be valid.
    pub fn voxel(&self, i: u32, j: u32, k: u32) -> bool {
        self.slab(i, j, k) >> ((j & 7) * 8 + (i & 7)) & 1 == 1
    }

    /// The 8 × 8 × 1 slab that holds voxel (i, j, k): bit y·8 + x, 1 = lit.
    pub fn slab(&self, i: u32, j: u32, k: u32) -> u64 {
        self.descend(i, j, k)
    }

    fn four_units(&self, at: usize) -> u64 {
        self.units[at..at + 4].iter().rev().fold(0, |mask, &unit| mask << 16 | u64::from(unit))
    }

    /// Unit where a level's pool begins; that of the level above is where it ends.
    fn pool(&self, level: u32) -> u32 {
        self.top[(level - SLAB_NODE_LEVEL) as usize]
    }

    /// Index in `top` of the first root.
    fn roots_at(&self) -> usize {
        POOL_WORDS + 2 * self.top_dims[0] as usize * self.top_dims[1] as usize + 1
    }
}

impl Descend for PackedDag {
    fn root_level(&self) -> u32 {
        self.root_level
    }

    fn root(&self, i: u32, j: u32, k: u32) -> Step {
        let [gx, gy, gz] = [i, j, k].map(|c| c >> self.root_level);
        if gx >= self.top_dims[0] || gy >= self.top_dims[1] || gz >= self.top_dims[2] {
            return Step::Uniform(true);
        }
        let column = POOL_WORDS + 2 * (gy as usize * self.top_dims[0] as usize + gx as usize);
        let [first, z0, end] = [self.top[column], self.top[column + 1], self.top[column + 2]];
        if gz < z0 {
            return Step::Uniform(true);
        }
        let root = first + (gz - z0);
        if root >= end {
            return Step::Uniform(false);
        }
        Step::Into(self.pool(self.root_level) + self.top[self.roots_at() + root as usize])
    }

    fn child(&self, at: u32, level: u32, i: u32, j: u32, k: u32) -> Step {
        let bit = level - 1;
        let quarter = (i >> bit & 1) << 1 | j >> bit & 1;
        let far_half = k >> bit & 1 == 1;
        let unit = u32::from(self.units[at as usize]);
        let before = pointers_in(unit & bits_below(3 * quarter));
        let pointer = match (unit >> (3 * quarter) & 7, far_half) {
            (0, _) | (2 | 5, true) => return Step::Uniform(false),
            (1, _) | (2 | 4, false) => return Step::Uniform(true),
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
        // An eighth pointer is never the one that the header names.
        if pointer == follower && pointer != NO_FOLLOWER {
            return Step::Into(slots_at + slots);
        }
        let slot = slots_at + pointer - u32::from(pointer > follower);
        let value = u32::from(self.units[slot as usize]);
        Step::Into(if wide >> pointer & 1 == 1 {
            self.pool(level - 1) + (high << 16 | value)
        } else if value < NEAR_UNITS {
            slots_at + slots + value
        } else {
            self.pool(level - 1) + value - NEAR_UNITS
        })
    }

    fn slab_of_cube(&self, at: u32, k: u32) -> u64 {
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
        let here = node::masks_here(unit);
        let place = follow + (mask + 3 * (here & bits_below(mask)).count_ones()) as usize;
        if here >> mask & 1 == 1 {
            self.four_units(place)
        } else {
            self.slabs[usize::from(self.units[place])]
        }
    }

    fn fill_of_cube(&self, at: u32, k: u32, slabs: &mut [u64; 8]) -> u8 {
        let changes = u32::from(self.units[at as usize]) & 0xff;
        let slab = self.slab_of_cube(at, k);
        // As it are all back to the change before it and on to the next one.
        let from = (changes & bits_below(k + 1)).checked_ilog2().unwrap_or(0);
        let to = (changes >> k >> 1 | 1 << (7 - k)).trailing_zeros() + k + 1;
        slabs[from as usize..to as usize].fill(slab);
        (bits_below(to) & !bits_below(from)) as u8
    }
}

impl Slabs for PackedDag {
    fn size(&self) -> [u32; 3] {
        self.size
    }

    fn slab(&self, i: u32, j: u32, k: u32) -> u64 {
        Self::slab(self, i, j, k)
    }

    fn slab_along(&self, trail: &mut Trail, i: u32, j: u32, k: u32) -> u64 {
        self.slab_on(trail, i, j, k)
    }

    fn fill_along(&self, trail: &mut Trail, voxel: [u32; 3], slabs: &mut [u64; 8]) -> u8 {
        self.fill_on(trail, voxel, slabs)
    }

    fn end_level(&self, i: u32, j: u32, k: u32) -> u32 {
        Descend::end_level(self, i, j, k)
    }
}
