//! The multiresolution hierarchy: a second layout of a light-aligned bake, an image of switch depths in place of voxels.
//!
//! Source: Scandolo, Bauszat, Eisemann, *Compressed Multiresolution Hierarchies for High-Quality Precomputed Shadows* and *Merged
//! Multiresolution Hierarchies for Shadow Map Compression*, both 2016: values inside each column's interval, inherited from
//! node to node; values relative to the parent's, so that equal shapes at different depths are one. Departures: a node has 4 × 4
//! children, a leaf is 8 × 8 columns with an outline once and its depths apart, columns that are lit to their end say so and need no
//! value, and equal shapes are found by hash, once depths were chosen, not by a search.
//!
//! # Words
//! `code` is half-words of 16 bits, two a word, the lower first. A *shape* begins at a half-word, its address, and has no depth of its own:
//! it is told a *base* depth. Shapes that it points to stand before it. A root spans 2^root_level columns a side; root_level
//! is 5, 7 or 9.
//!
//! | part | words | meaning |
//! |---|---|---|
//! | top | 2 a root, x fastest | address, or [`UNIFORM`]; base, or [`NEVER`] |
//! | wide | 2 each | what one half-word cannot add to a base, as 32 bits in two's complement; address, or [`UNIFORM`] |
//! | code | | shapes: nodes at levels above 3, leaves at level 3 |
//!
//! A node of level n has children of level n − 2: child `y·4 + x`. Its first three half-words have a bit for each of them; what they
//! say follows in the children's order.
//!
//! | size (half-words 0 and 1) | kind (half-word 2) | then | the child |
//! |---|---|---|---|
//! | 0 | 0 | | switches at the base |
//! | 0 | 1 | | never switches |
//! | 1 | 0 | near | a shape, same base |
//! | 1 | 1 | delta | switches at base + delta |
//! | 2 | 0 | far | a shape, same base |
//! | 2 | 1 | delta, near | a shape, base + delta |
//! | 3 | 0 | delta, far | a shape, base + delta |
//! | 3 | 1 | index, lower half first; 0 | entry of `wide`: a shape or a switch, base + its delta |
//!
//! *near*: an address below 2^15, or bit 15 = 1 and bits 14..0 = half-words from the shape's address back to it. *far*: an address, lower half
//! first. *delta*: two's complement.
//!
//! A leaf has n = 1 to 64 different depths v0 < v1 < … of which the last may be [`NEVER`]; v0 is the base. A *slanted* one has planes in their
//! place: gx and gy quarters of a voxel a column, and the depths are those at the plane's deepest corner. Column (x, y) then switches nearer
//! by `(|gx|·dx + |gy|·dy + 3) >> 2`, where dx = 7 − x for gx > 0, else x, and dy likewise. Depths of a leaf end at 0 and at [`NEVER`]:
//! a sum that would pass them is the nearer of the two.
//!
//! | half-words | meaning |
//! |---|---|
//! | 1 | bits 5..0: n − 1; bit 6: the last never switches; bits 8..7: w, its differences take 8 << w bits; bit 9: slanted; the rest zero |
//! | 1 if slanted | gx in bits 7..0, gy in bits 15..8, two's complement |
//! | by w | v1 − v0, v2 − v1, … without that to a last one that never switches; padded with zeros |
//! | 4 a plane | bit p of each column's rank among the depths, p from 0; column `y·8 + x` is that bit of the 64, lowest half-word first |
//!
//! Worked value: columns of row 0 that switch at 7, all others never: `0x0041`, `0xff00`, `0xffff`, `0xffff`, `0xffff`, with base 7.

mod census;
mod choose;
mod code;
mod convert;
mod encode;
#[cfg(test)]
mod from_columns;
mod leaf;
pub(crate) mod sink;
mod slant;
mod store;
#[cfg(test)]
mod tests;
mod validate;

pub use census::Census;
pub use validate::HierarchyError;

use crate::dag::{Slabs, Trail};
use code::{Code, Place};

/// Depth of a column that never switches: lit to its end.
pub const NEVER: u32 = u32::MAX;
/// In place of an address: every column switches at the base.
pub const UNIFORM: u32 = u32::MAX;
/// Columns of a leaf along a side, as a level.
pub const LEAF_LEVEL: u32 = 3;
/// Levels from a node to its children.
pub const NODE_LEVELS: u32 = 2;

/// A complete hierarchy.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Hierarchy {
    /// Voxels along x, y, z.
    pub size: [u32; 3],
    /// A root spans 2^root_level columns a side: 5, 7 or 9.
    pub root_level: u32,
    /// Roots along x, y: `ceil(size / 2^root_level)`.
    pub top_dims: [u32; 2],
    /// Address and base of each root, x fastest.
    pub top: Vec<[u32; 2]>,
    /// Differences of depth that need more than 16 bits, with the addresses that they lead to.
    pub wide: Vec<[u32; 2]>,
    /// Half-words of all shapes.
    pub code: Vec<u32>,
}

impl Hierarchy {
    /// Depth at which column (i, j) switches: voxel k is lit where k is smaller. [`NEVER`]: all are. Outside the grid: never.
    ///
    /// Cost: one step each two levels above 3, then a leaf.
    pub fn value(&self, i: u32, j: u32) -> u32 {
        match self.place(i, j).0 {
            Place::Uniform(value) => value,
            Place::Leaf { at, base } => self.shapes().leaf(at, base).value((j & 7) * 8 + (i & 7)),
        }
    }

    /// The 8 × 8 × 1 slab that holds voxel (i, j, k): bit y·8 + x, 1 = lit.
    ///
    /// Cost: as [`Hierarchy::value`], and a step for each depth of the leaf.
    pub fn slab(&self, i: u32, j: u32, k: u32) -> u64 {
        match self.place(i, j).0 {
            Place::Uniform(value) if k < value => u64::MAX,
            Place::Uniform(_) => 0,
            Place::Leaf { at, base } => self.shapes().leaf(at, base).slab(k),
        }
    }

    /// Bytes of all words.
    pub fn bytes(&self) -> u64 {
        8 * (self.top.len() + self.wide.len()) as u64 + 4 * self.code.len() as u64
    }

    fn shapes(&self) -> Code<'_> {
        Code { words: &self.code, wide: &self.wide }
    }

    /// What holds a column, and its level.
    #[inline]
    fn place(&self, i: u32, j: u32) -> (Place, u32) {
        let [x, y] = [i, j].map(|c| c >> self.root_level);
        if x >= self.top_dims[0] || y >= self.top_dims[1] {
            return (Place::Uniform(NEVER), self.root_level);
        }
        let [at, base] = self.top[(y * self.top_dims[0] + x) as usize];
        self.shapes().descend(at, base, self.root_level, [i, j])
    }
}

impl Slabs for Hierarchy {
    fn size(&self) -> [u32; 3] {
        self.size
    }

    fn slab(&self, i: u32, j: u32, k: u32) -> u64 {
        Hierarchy::slab(self, i, j, k)
    }

    fn fill_along(&self, _trail: &mut Trail, [i, j, k]: [u32; 3], slabs: &mut [u64; 8]) -> u8 {
        let first = k & !7;
        *slabs = match self.place(i, j).0 {
            Place::Uniform(value) => {
                std::array::from_fn(|z| if first + (z as u32) < value { u64::MAX } else { 0 })
            }
            Place::Leaf { at, base } => self.shapes().leaf(at, base).cube(first),
        };
        u8::MAX
    }

    fn end_level(&self, i: u32, j: u32, _k: u32) -> u32 {
        match self.place(i, j) {
            (Place::Uniform(_), level) => level,
            (Place::Leaf { .. }, _) => 0,
        }
    }
}
