//! The columns of a rectangle of texels, and of an 8 × 8 block, the input of sinks.

use crate::columns::rules::BESIDE_GRID;

/// Side of the smallest block, in columns.
pub(crate) const BLOCK_SIDE: usize = 8;

/// `[e, x]` of every column of a rectangle.
#[derive(Default)]
pub(crate) struct Columns {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// End of the range that must be lit.
    pub(crate) e: Vec<u32>,
    /// Start of the range that must be shadowed.
    pub(crate) x: Vec<u32>,
}

impl Columns {
    pub(crate) fn reset(&mut self, width: u32, height: u32) {
        self.width = width;
        self.height = height;
        for v in [&mut self.e, &mut self.x] {
            v.clear();
            v.resize((width * height) as usize, 0);
        }
    }

    pub(crate) fn set(&mut self, texel: usize, [e, x]: [u32; 2]) {
        self.e[texel] = e;
        self.x[texel] = x;
    }

    /// Lets a column's shadow begin as late as `x`.
    pub(crate) fn extend(&mut self, texel: usize, x: u32) {
        self.x[texel] = self.x[texel].max(x);
    }
}

/// `[e, x]` of an 8 × 8 block of columns, texel y·8 + x. Columns outside the grid are `[0, BESIDE_GRID]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockColumns {
    /// First voxel of each column that need not be lit.
    pub e: [u32; BLOCK_SIDE * BLOCK_SIDE],
    /// First voxel of each column that must be shadowed.
    pub x: [u32; BLOCK_SIDE * BLOCK_SIDE],
}

impl BlockColumns {
    /// Returns unconstrained columns.
    pub fn free() -> Self {
        Self { e: [0; BLOCK_SIDE * BLOCK_SIDE], x: [BESIDE_GRID; BLOCK_SIDE * BLOCK_SIDE] }
    }

    /// Pads at most 8 × 8 columns to a block. Missing columns are free.
    pub(crate) fn padded(columns: &Columns) -> Self {
        let mut block = Self::free();
        let width = columns.width as usize;
        for y in 0..columns.height as usize {
            let (from, to) = (y * width, y * BLOCK_SIDE);
            block.e[to..to + width].copy_from_slice(&columns.e[from..from + width]);
            block.x[to..to + width].copy_from_slice(&columns.x[from..from + width]);
        }
        block
    }
}
