//! The directed acyclic graph of a light-aligned bake: a grid of roots, inner nodes, leaf masks.
//!
//! | part | word | meaning |
//! |---|---|---|
//! | top grid | `top[(gz·dims.y + gy)·dims.x + gx]` | [`LIT`], [`SHADOWED`], or index of the root's header in `nodes` |
//! | header | bits 15..0 | two bits per child, child c at bits 2c+1..2c: 0 shadowed, 1 lit, 2 mixed; 3 is invalid |
//! | header | bits 31..16 | zero |
//! | pointer | 32 bits | one per mixed child, in child order, directly after the header |
//! | leaf mask | 64 bits | visibility of 8 × 8 × 1 voxels, bit y·8 + x, 1 = lit |
//!
//! A node of level n spans 2^n voxels along each side. Above level 3, a node's child is
//! `(x_bit << 2) | (y_bit << 1) | z_bit` and its pointers index `nodes`. At level 3, child c is the leaf mask
//! at z = c and pointers index `leaf_masks`. All-lit and all-shadowed nodes do not occur, because their
//! parents store that state. So a header without a mixed child occurs only if its children differ.
//!
//! Worked value: a level-3 node whose first two leaf masks are lit, the third mixed and the rest shadowed has
//! the header `0b00_00_00_00_00_10_01_01` = 0x0025 and one pointer.

mod validate;

pub use validate::{GraphError, GraphPlace};

use crate::dag::composition::Composition;

use super::descend::{Descend, Descent, uniform};

/// Top-grid entry of a root cube that is all lit.
pub const LIT: u32 = u32::MAX;
/// Top-grid entry of a root cube that is all shadowed.
pub const SHADOWED: u32 = u32::MAX - 1;
/// State of a child that is all shadowed.
pub const STATE_SHADOWED: u32 = 0;
/// State of a child that is all lit.
pub const STATE_LIT: u32 = 1;
/// State of a mixed child, which has a pointer.
pub const STATE_MIXED: u32 = 2;

/// A complete, canonically numbered graph.
///
/// A look-up costs one step per level above 3, then two. Voxels outside the top grid are lit; the caller
/// handles points outside the grid, see [`adumbra::query`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Dag {
    /// Number of voxels along x, y, z in use. The top grid may cover a little more.
    pub size: [u32; 3],
    /// A root cube spans 2^root_level voxels along each side; at least 3.
    pub root_level: u32,
    /// Number of root cubes along x, y, z: `ceil(size / 2^root_level)`.
    pub top_dims: [u32; 3],
    /// One entry per root cube, x fastest, then y, then z.
    pub top: Vec<u32>,
    /// Headers and pointers; the subtrees of the roots in pre-order of first visit over the top grid.
    pub nodes: Vec<u32>,
    /// Leaf masks in order of first visit.
    pub leaf_masks: Vec<u64>,
}

impl Dag {
    /// Returns child `child` of the node at `word`: its state, or the index of its header, at level 3 of its
    /// leaf mask.
    fn step(&self, word: u32, child: u32) -> Descent {
        let header = self.nodes[word as usize];
        match header >> (2 * child) & 3 {
            STATE_SHADOWED => return Descent::Uniform(false),
            STATE_LIT => return Descent::Uniform(true),
            _ => {}
        }
        let mixed_before = (header & 0xaaaa & ((1 << (2 * child)) - 1)).count_ones();
        Descent::Into(self.nodes[(word + 1 + mixed_before) as usize])
    }

    /// Returns the number of headers in [`Dag::nodes`].
    pub fn node_count(&self) -> u64 {
        let mut count = 0;
        let mut at = 0;
        while let Some(header) = self.nodes.get(at) {
            count += 1;
            at += 1 + (header & 0xaaaa).count_ones() as usize;
        }
        count
    }
}

impl Descend for Dag {
    fn size(&self) -> [u32; 3] {
        self.size
    }

    fn root_level(&self) -> u32 {
        self.root_level
    }

    fn root(&self, i: u32, j: u32, k: u32) -> Descent {
        let root = [i, j, k].map(|c| c >> self.root_level);
        if (0..3).any(|a| root[a] >= self.top_dims[a]) {
            return Descent::Uniform(true);
        }
        let [tx, ty, tz] = root.map(|c| c as usize);
        let [nx, ny] = [self.top_dims[0] as usize, self.top_dims[1] as usize];
        match self.top[(tz * ny + ty) * nx + tx] {
            LIT => Descent::Uniform(true),
            SHADOWED => Descent::Uniform(false),
            word => Descent::Into(word),
        }
    }

    fn child(&self, word: u32, level: u32, i: u32, j: u32, k: u32) -> Descent {
        let bit = level - 1;
        self.step(word, (i >> bit & 1) << 2 | (j >> bit & 1) << 1 | k >> bit & 1)
    }

    fn leaf_mask_of_cube(&self, word: u32, k: u32) -> u64 {
        match self.step(word, k) {
            Descent::Uniform(lit) => uniform(lit),
            Descent::Into(leaf_mask) => self.leaf_masks[leaf_mask as usize],
        }
    }
}

impl Dag {
    /// Returns the breakdown of the graph's bytes. Cost: one read of each header.
    pub fn composition(&self) -> Composition {
        let (nodes, leaf_masks) = (self.node_count(), self.leaf_masks.len() as u64);
        Composition {
            nodes,
            leaf_masks,
            top_bytes: self.top.len() as u64 * 4,
            header_bytes: nodes * 4,
            pointer_bytes: (self.nodes.len() as u64 - nodes) * 4,
            leaf_mask_bytes: leaf_masks * 8,
        }
    }
}
