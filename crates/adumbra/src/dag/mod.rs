//! The directed acyclic graph of a light-aligned bake: a grid of roots, inner nodes, slabs.
//!
//! | part | word | meaning |
//! |---|---|---|
//! | top grid | `top[(gz·dims.y + gy)·dims.x + gx]` | [`LIT`], [`SHADOWED`], or the index of the root's header in `nodes` |
//! | header | bits 15..0 | two bits a child, child c at bits 2c+1..2c: 0 shadowed, 1 lit, 2 mixed; 3 never |
//! | header | bits 31..16 | zero |
//! | pointer | 32 bits | one a mixed child, in child order, right behind the header |
//! | slab | 64 bits | visibility of 8 × 8 × 1 voxels, bit y·8 + x, 1 = lit |
//!
//! A node of level n spans 2^n voxels a side. Above level 3 a node's child is `(x_bit << 2) | (y_bit << 1) | z_bit` and
//! its pointers index `nodes`; at level 3 child c is the slab at z = c and pointers index `slabs`. A header with no mixed
//! child does not occur (its parent says lit or shadowed) unless its children differ: all-lit and all-shadowed nodes do
//! not occur. Worked value: a level-3 node whose first two slabs are lit, third mixed, the rest shadowed has header
//! `0b00_00_00_00_00_10_01_01` = 0x0025 and one pointer.

mod canonical;
mod composition;
pub mod packed;
pub mod store;
mod too_large;
mod top_error;
mod trail;
mod validate;

pub(crate) use canonical::PagedDag;
pub use composition::Composition;
pub(crate) use too_large::MAX_CONVERTED_DEPTH;
pub use too_large::{MAX_CONVERTED_ROOTS, TooLarge};
pub use top_error::TopError;
pub use trail::Trail;
use trail::{Descend, Step};
pub use validate::{GraphError, GraphPlace, MAX_ROOT_LEVEL};

/// Top-grid entry: the whole root cube is lit.
pub const LIT: u32 = u32::MAX;
/// Top-grid entry: the whole root cube is shadowed.
pub const SHADOWED: u32 = u32::MAX - 1;
/// Child state: all shadowed.
pub const STATE_SHADOWED: u32 = 0;
/// Child state: all lit.
pub const STATE_LIT: u32 = 1;
/// Child state: mixed, with a pointer.
pub const STATE_MIXED: u32 = 2;
/// Level of the nodes whose children are slabs.
pub const SLAB_NODE_LEVEL: u32 = 3;

/// A complete, canonically numbered graph.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Dag {
    /// Voxels along x, y, z that mean anything; the top grid may cover a little more.
    pub size: [u32; 3],
    /// A root cube spans 2^root_level voxels a side; at least 3.
    pub root_level: u32,
    /// Root cubes along x, y, z: `ceil(size / 2^root_level)`.
    pub top_dims: [u32; 3],
    /// One entry a root cube, x fastest, then y, then z.
    pub top: Vec<u32>,
    /// Headers and pointers, root subtrees in pre-order of first visit over the top grid.
    pub nodes: Vec<u32>,
    /// Slab masks in order of first visit.
    pub slabs: Vec<u64>,
}

impl Dag {
    /// Visibility of the voxel (i, j, k); outside the top grid it is lit.
    ///
    /// Cost: one step a level above 3, then two. The caller says what lies beside the grid: see [`crate::query`].
    pub fn voxel(&self, i: u32, j: u32, k: u32) -> bool {
        self.slab(i, j, k) >> ((j & 7) * 8 + (i & 7)) & 1 == 1
    }

    /// The 8 × 8 × 1 slab that holds voxel (i, j, k): bit y·8 + x, 1 = lit.
    pub fn slab(&self, i: u32, j: u32, k: u32) -> u64 {
        self.descend(i, j, k)
    }

    /// What child `child` of the node at this word is: a word, at level 3 a slab.
    fn step(&self, word: u32, child: u32) -> Step {
        let header = self.nodes[word as usize];
        match header >> (2 * child) & 3 {
            STATE_SHADOWED => return Step::Uniform(false),
            STATE_LIT => return Step::Uniform(true),
            _ => {}
        }
        let mixed_before = (header & 0xaaaa & ((1 << (2 * child)) - 1)).count_ones();
        Step::Into(self.nodes[(word + 1 + mixed_before) as usize])
    }

    /// Headers among [`Dag::nodes`].
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
    fn root_level(&self) -> u32 {
        self.root_level
    }

    fn root(&self, i: u32, j: u32, k: u32) -> Step {
        let root = [i, j, k].map(|c| c >> self.root_level);
        if (0..3).any(|a| root[a] >= self.top_dims[a]) {
            return Step::Uniform(true);
        }
        let [tx, ty, tz] = root.map(|c| c as usize);
        let [nx, ny] = [self.top_dims[0] as usize, self.top_dims[1] as usize];
        match self.top[(tz * ny + ty) * nx + tx] {
            LIT => Step::Uniform(true),
            SHADOWED => Step::Uniform(false),
            word => Step::Into(word),
        }
    }

    fn child(&self, word: u32, level: u32, i: u32, j: u32, k: u32) -> Step {
        let bit = level - 1;
        self.step(word, (i >> bit & 1) << 2 | (j >> bit & 1) << 1 | k >> bit & 1)
    }

    fn slab_of_cube(&self, word: u32, k: u32) -> u64 {
        match self.step(word, k) {
            Step::Uniform(lit) => trail::uniform(lit),
            Step::Into(slab) => self.slabs[slab as usize],
        }
    }
}

/// A structure that answers slabs of 8 × 8 × 1 voxels of a light-aligned grid.
pub trait Slabs: Sync {
    /// Voxels along x, y, z.
    fn size(&self) -> [u32; 3];

    /// The slab that holds voxel (i, j, k), which lies in the grid: bit y·8 + x, 1 = lit.
    fn slab(&self, i: u32, j: u32, k: u32) -> u64;

    /// Level of the block in which a look-up of voxel (i, j, k), which lies in the grid, ends: it is all lit or all shadowed and spans
    /// 2^level voxels a side, at level 3 also a slab of 8 × 8 × 1; 0 = a single voxel, or a single column.
    fn end_level(&self, i: u32, j: u32, k: u32) -> u32;

    /// The slab that holds a voxel, from the last place on that has this `trail`: cheap where both have most of their way in common. A trail
    /// is for look-ups in one structure only.
    fn slab_along(&self, _trail: &mut Trail, i: u32, j: u32, k: u32) -> u64 {
        self.slab(i, j, k)
    }

    /// Writes [`Slabs::slab_along`] into its place among the eight slabs of a cube of 8 × 8 × 8 voxels, the nearest first, and with it those
    /// that are known at no further cost; which those are, as bits.
    fn fill_along(&self, trail: &mut Trail, [i, j, k]: [u32; 3], slabs: &mut [u64; 8]) -> u8 {
        slabs[(k & 7) as usize] = self.slab_along(trail, i, j, k);
        1 << (k & 7)
    }
}

impl Slabs for Dag {
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
