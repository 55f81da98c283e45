//! Depths: a quadtree of the depths at which columns switch from lit to shadowed, in place of voxels.
//!
//! Source: Scandolo, Bauszat, Eisemann, *Compressed Multiresolution Hierarchies for High-Quality Precomputed Shadows*
//! and *Merged Multiresolution Hierarchies for Shadow Map Compression*, both 2016. As there, values are chosen inside
//! each column's interval and inherited from node to node, and they are relative to the parent's, so that equal shapes
//! at different depths are stored once. This layout departs from the source in several points. A node has 4 × 4
//! children. A leaf has 8 × 8 columns and stores its contour once, separately from its depths. Columns that are lit to
//! their end are marked as such and need no value. Equal shapes are found by hash after the depths have been chosen,
//! not by a search.
//!
//! # Words
//! `code` is a sequence of half-words of 16 bits, two per word, the lower first. A *shape* begins at a half-word, its
//! address. It has no depth of its own, but receives a *base* depth. The shapes that it points to come before it. A
//! root spans 2^root_level columns along each side, where root_level is 5, 7 or 9.
//!
//! | part | words | meaning |
//! |---|---|---|
//! | top | 2 per root, x fastest | address, or [`UNIFORM`]; base, or [`NEVER`] |
//! | wide | 2 each | delta that does not fit a half-word, 32 bits, two's complement; address, or [`UNIFORM`] |
//! | code | | shapes: nodes at levels above 3, leaves at level 3 |
//!
//! A node of level n has 4 × 4 children of level n − 2, with index `y·4 + x`. Its first three half-words have one bit
//! per child. The fields that these bits call for follow in the children's order.
//!
//! | size (half-words 0 and 1) | kind (half-word 2) | fields | child |
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
//! *near*: an address below 2^15, or bit 15 = 1 and bits 14..0 = number of half-words from the shape's address back to
//! it. *far*: an address, lower half first. *delta*: two's complement.
//!
//! A leaf has n = 1 to 64 different depths v0 < v1 < …, of which the last may be [`NEVER`]; v0 is the base. A *slanted*
//! leaf has parallel planes instead of depths. Their gradient is gx and gy quarters of a voxel per column, and the
//! stored depths are those at the deepest corner of each plane. Column (x, y) then switches nearer to the sun by
//! `(|gx|·dx + |gy|·dy + 3) >> 2`, where dx = 7 − x for gx > 0, else x, and dy is 7 − y for gy > 0, else y. Depths of a
//! leaf saturate at 0 and at [`NEVER`].
//!
//! | half-words | meaning |
//! |---|---|
//! | 1 | bits 5..0: n − 1; 6: the last never switches; 8..7: w, differences take 8 << w bits; 9: slanted; rest 0 |
//! | 1 if slanted | gx in bits 7..0, gy in bits 15..8, two's complement |
//! | by w | v1 − v0, v2 − v1, … except the one to a last depth that never switches; padded with zeros |
//! | 4 per plane | bit p of each column's rank among the depths, p from 0; column `y·8 + x` is that bit of the 64 |
//!
//! The four half-words of a plane are stored lowest first.
//!
//! Worked value: if the columns of row 0 switch at 7 and all others never switch, the leaf is `0x0041`, `0xff00`,
//! `0xffff`, `0xffff`, `0xffff`, with base 7.

mod census;
pub mod code;
pub mod slant;
mod validate;

pub use census::Census;
pub use validate::DepthsError;

use code::{Code, Place};

/// Depth of a column that never switches, that is, one that is lit to its end.
pub const NEVER: u32 = u32::MAX;
/// Stored in place of an address if every column switches at the base.
pub const UNIFORM: u32 = u32::MAX;
/// Level of a leaf: it has 2^3 columns along each side.
pub const LEAF_LEVEL: u32 = 3;
/// Number of levels from a node to its children.
pub const NODE_LEVELS: u32 = 2;

/// A complete quadtree of switch depths.
///
/// A look-up of a leaf mask costs one step per two levels above 3, then one step per depth of the leaf.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DepthTree {
    /// Number of voxels along x, y, z.
    pub size: [u32; 3],
    /// A root spans 2^root_level columns along each side: 5, 7 or 9.
    pub root_level: u32,
    /// Number of roots along x, y: `ceil(size / 2^root_level)`.
    pub top_dims: [u32; 2],
    /// Address and base of each root, x fastest.
    pub top: Vec<[u32; 2]>,
    /// Differences of depth that need more than 16 bits, each with the address of its shape, or [`UNIFORM`].
    pub wide: Vec<[u32; 2]>,
    /// Half-words of all shapes, two per word.
    pub code: Vec<u32>,
}

/// Bounds of the depths at which the columns of a block of 8 × 8 switch from lit to shadowed: voxel k of a column is lit
/// if k is less than the column's depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Switches {
    /// No column switches nearer to the sun.
    pub nearest: u32,
    /// No column switches deeper.
    pub farthest: u32,
    /// What [`DepthTree::switches_of_leaf`] reads the columns' depths from; `None` if all are equal to both bounds.
    pub leaf: Option<[u32; 2]>,
}

impl DepthTree {
    /// Returns the depth at which column (i, j) switches: voxel k is lit if k is less than it. [`NEVER`] if all voxels
    /// of the column are lit, and outside the grid.
    ///
    /// Cost: one step per two levels above 3, then one leaf.
    pub fn value(&self, i: u32, j: u32) -> u32 {
        match self.place(i, j).0 {
            Place::Uniform(value) => value,
            Place::Leaf { at, base } => self.shapes().leaf(at, base).value((j & 7) * 8 + (i & 7)),
        }
    }

    /// Returns the size of all words in bytes.
    pub fn bytes(&self) -> u64 {
        8 * (self.top.len() + self.wide.len()) as u64 + 4 * self.code.len() as u64
    }

    /// Returns a reader of the individual shapes.
    #[inline]
    pub fn shapes(&self) -> Code<'_> {
        Code { words: &self.code, wide: &self.wide }
    }

    /// Returns the block or leaf that contains a column, and its level.
    #[inline]
    pub fn place(&self, i: u32, j: u32) -> (Place, u32) {
        let [x, y] = [i, j].map(|c| c >> self.root_level);
        if x >= self.top_dims[0] || y >= self.top_dims[1] {
            return (Place::Uniform(NEVER), self.root_level);
        }
        let [at, base] = self.top[(y * self.top_dims[0] + x) as usize];
        self.shapes().descend(at, base, self.root_level, [i, j])
    }

    /// Returns whether voxel (i, j, k) is lit. The voxel must be in the grid.
    pub fn voxel(&self, i: u32, j: u32, k: u32) -> bool {
        k < self.value(i, j)
    }

    /// Returns the level of the block in which a look-up in column (i, j) ends. The column must be in the grid.
    ///
    /// The block switches at one depth and spans 2^level columns along each side. Level 0 is a single column.
    pub fn end_level(&self, i: u32, j: u32) -> u32 {
        match self.place(i, j) {
            (Place::Uniform(_), level) => level,
            (Place::Leaf { .. }, _) => 0,
        }
    }

    /// Returns bounds of the depths at which the columns of the block of 8 × 8 that contains column (i, j) switch. The
    /// column must be in the grid. Columns outside the grid may have any depth.
    pub fn switches(&self, i: u32, j: u32) -> Switches {
        match self.place(i, j).0 {
            Place::Uniform(value) => Switches { nearest: value, farthest: value, leaf: None },
            Place::Leaf { at, base } => {
                let [nearest, farthest] = self.shapes().leaf(at, base).bounds();
                Switches { nearest, farthest, leaf: Some([at, base]) }
            }
        }
    }

    /// Returns the depths at which the columns of a block switch, in the order y·8 + x. `leaf` is from
    /// [`DepthTree::switches`] of the same tree.
    pub fn switches_of_leaf(&self, [at, base]: [u32; 2]) -> [u32; 64] {
        self.shapes().leaf(at, base).values()
    }
}
