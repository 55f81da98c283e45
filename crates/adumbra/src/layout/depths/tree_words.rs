//! Look-ups in the words of a quadtree, which are in a file that was read whole, or in a pool.

use crate::layout::depths::code::{Code, ColumnNode, Node};
use crate::layout::depths::{NEVER, UNIFORM};

/// Stored in place of an address if the block's page is not resident. A file that was read whole has no such
/// blocks.
pub const ABSENT: u32 = u32::MAX - 1;

/// The words of a quadtree.
#[derive(Clone, Copy, Debug)]
pub struct TreeWords<'w> {
    /// Number of voxels along x, y, z.
    pub size: [u32; 3],
    /// Level of the blocks at which look-ups begin: they span 2^level columns along each side.
    pub block_level: u32,
    /// Number of these blocks along x and y.
    pub block_dims: [u32; 2],
    /// Address in the code and base of each block, x fastest.
    pub blocks: &'w [[u32; 2]],
    /// The common section, and pages somewhere behind it.
    pub code: &'w [u32],
}

impl<'w> TreeWords<'w> {
    /// Returns a reader of the individual shapes.
    #[inline]
    pub fn shapes(self) -> Code<'w> {
        Code { words: self.code }
    }

    /// Returns the block or leaf that contains a column, and its level. The column's page must be resident.
    #[inline]
    pub fn place(self, i: u32, j: u32) -> (ColumnNode, u32) {
        self.shapes().descend(self.root(i, j), [i, j])
    }

    /// Returns the root that contains a column. Outside the grid, no column switches.
    #[inline]
    pub fn root(self, i: u32, j: u32) -> Node {
        let level = self.block_level;
        let [x, y] = [i, j].map(|c| c >> level);
        if x >= self.block_dims[0] || y >= self.block_dims[1] {
            return Node { at: UNIFORM, base: NEVER, level };
        }
        let [at, base] = self.blocks[(y * self.block_dims[0] + x) as usize];
        Node { at, base, level }
    }

    /// Whether the pages of all columns low…high are resident. The columns must be in the grid.
    pub fn are_resident(self, low: [u32; 2], high: [u32; 2]) -> bool {
        let [low, high] = [low, high].map(|column| column.map(|c| c >> self.block_level));
        (low[1]..=high[1]).all(|y| {
            let row = (y * self.block_dims[0]) as usize;
            self.blocks[row..][low[0] as usize..=high[0] as usize].iter().all(|block| block[0] != ABSENT)
        })
    }

    /// Returns the depth at which column (i, j) switches, see [`DepthTree::value`](super::DepthTree::value).
    #[inline(always)]
    pub fn value(self, i: u32, j: u32) -> u32 {
        match self.place(i, j).0 {
            ColumnNode::Uniform(value) => value,
            ColumnNode::Leaf { at, base } => self.shapes().leaf(at, base).value((j & 7) * 8 + (i & 7)),
        }
    }
}
