//! Depths along the border of the coded area.
//!
//! The blocks above and to the left of a block are coded before it, and no other block of the same columns or
//! rows is coded in between. One row and one column of depths are therefore enough.

use super::contour::{NEVER_CELL, Outline, class};
use super::shapes::Pool;
use crate::layout::depths::child::Child;
use crate::layout::depths::page::{BUNDLE_SIDE, PAGE_LEVEL};
use crate::layout::depths::shapes::Shape;
use crate::layout::depths::slant::{SLANT_BITS, Slant};
use crate::layout::depths::{LEAF_LEVEL, NEVER, NODE_LEVELS, UNIFORM};

/// Number of columns along each side of a bundle.
const SIDE: usize = (BUNDLE_SIDE as usize) << PAGE_LEVEL;

/// A neighbouring block, above or to the left, as a predictor for a block of 8 × 8 columns.
#[derive(Clone, Copy)]
pub(super) struct Facing {
    /// See [`class`].
    pub(super) class: u8,
    /// 0 if the block is uniform, else its [`Outline::kind`].
    pub(super) kind: u8,
    /// Gradient of a leaf, or 0.
    pub(super) slant: u16,
    /// The leaf's shape, or [`UNIFORM`].
    pub(super) shape: u32,
}

const UNKNOWN: Facing = Facing { class: class::UNKNOWN, kind: 0, slant: 0, shape: UNIFORM };

/// The border of the coded area.
pub(super) struct Edges {
    /// Depth of the last coded column of each x.
    pub(super) bottom: Vec<u32>,
    /// Depth of the last coded column of each y.
    pub(super) right: Vec<u32>,
    /// The last coded block of each x.
    pub(super) above: Vec<Facing>,
    /// The last coded block of each y.
    pub(super) left: Vec<Facing>,
}

impl Edges {
    /// Returns the border before anything is coded.
    pub(super) fn new() -> Self {
        let (cells, blocks) = (vec![NEVER; SIDE], vec![UNKNOWN; SIDE >> LEAF_LEVEL]);
        Self { bottom: cells.clone(), right: cells, above: blocks.clone(), left: blocks }
    }

    /// Forgets the neighbours above and to the left of a square.
    pub(super) fn forget(&mut self, at: [usize; 2], level: u32) {
        self.set(at, level, NEVER, UNKNOWN);
    }

    fn set(&mut self, [x, y]: [usize; 2], level: u32, depth: u32, facing: Facing) {
        let side = 1 << level;
        self.bottom[x..x + side].fill(depth);
        self.right[y..y + side].fill(depth);
        let blocks = side >> LEAF_LEVEL;
        self.above[x >> LEAF_LEVEL..][..blocks].fill(facing);
        self.left[y >> LEAF_LEVEL..][..blocks].fill(facing);
    }

    /// Notes a square that switches at one depth.
    #[inline]
    pub(super) fn uniform(&mut self, at: [usize; 2], level: u32, depth: u32) {
        let class = if depth == NEVER { class::NEVER } else { class::FLAT };
        self.set(at, level, depth, Facing { class, ..UNKNOWN });
    }

    /// Returns the depths of the columns above and to the left of a leaf, each plus the rise of the leaf's
    /// slant in that column. [`NEVER`] stays as it is.
    #[inline]
    pub(super) fn facing_cells(&self, [x, y]: [usize; 2], slant: u32) -> [u32; 16] {
        let mut cells = [0; 16];
        cells[..8].copy_from_slice(&self.bottom[x..x + 8]);
        cells[8..].copy_from_slice(&self.right[y..y + 8]);
        if slant != 0 {
            let slant = Slant::from_half(slant);
            let mut quarters = [slant.quarters(0, -1), slant.quarters(-1, 0)];
            for i in 0..8 {
                for (cell, quarters) in [(i, quarters[0]), (8 + i, quarters[1])] {
                    let risen = cells[cell].wrapping_add((quarters >> SLANT_BITS) as u32);
                    cells[cell] = if cells[cell] == NEVER { NEVER } else { risen };
                }
                quarters[0] -= i32::from(slant.x);
                quarters[1] -= i32::from(slant.y);
            }
        }
        cells
    }

    /// Notes a leaf.
    #[inline]
    pub(super) fn leaf(&mut self, [x, y]: [usize; 2], base: u32, shape: u32, outline: &Outline) {
        let depth = |cell: u32| if cell == NEVER_CELL { NEVER } else { base.wrapping_add(cell) };
        for (slot, &cell) in self.bottom[x..x + 8].iter_mut().zip(&outline.cells[..8]) {
            *slot = depth(cell);
        }
        for (slot, &cell) in self.right[y..y + 8].iter_mut().zip(&outline.cells[8..]) {
            *slot = depth(cell);
        }
        let facing = Facing { class: 0, kind: outline.kind, slant: outline.slant, shape };
        self.above[x >> LEAF_LEVEL] = Facing { class: outline.classes[0], ..facing };
        self.left[y >> LEAF_LEVEL] = Facing { class: outline.classes[1], ..facing };
    }

    /// Notes a shape that was coded before.
    pub(super) fn shape(&mut self, [x, y]: [usize; 2], level: u32, base: u32, shape: u32, pool: Pool<'_>) {
        let node = match pool.get(shape) {
            Shape::Leaf(halves) => return self.leaf([x, y], base, shape, &Outline::of(halves)),
            Shape::Node(node) => node,
        };
        let level = level - NODE_LEVELS;
        // The last row and the last column.
        for c in [3, 7, 11, 12, 13, 14, 15] {
            let at = [x + ((c & 3) << level), y + ((c >> 2) << level)];
            match node.child(c) {
                Child::Never => self.uniform(at, level, NEVER),
                Child::Uniform(delta) => self.uniform(at, level, base.wrapping_add(delta)),
                Child::Shape { shape, delta } => {
                    self.shape(at, level, base.wrapping_add(delta), shape, pool);
                }
            }
        }
    }
}
