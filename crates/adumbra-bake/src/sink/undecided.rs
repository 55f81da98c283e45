//! A block of columns whose depths are still intervals: they are intersected on the way up, and chosen on the
//! way down.
//!
//! Where a depth is free, the nearest one is chosen: the first surface, which penumbrae need.

use adumbra::layout::depths::NODE_LEVELS;
use adumbra::layout::depths::child::{Child, Children};
use adumbra::layout::depths::leaf::MOST_HALVES;
use adumbra::layout::depths::shapes::ShapeSet;

use crate::columns::BlockColumns;
use crate::columns::rules::{BESIDE_GRID, FREE_TO_END};
use crate::pack::choose::{holds_any, intersection, most_shared};
use crate::pack::leaf::{Leaf, sort_columns};

/// A block whose base may still be any depth in an interval.
#[derive(Clone)]
pub(super) struct Undecided {
    /// The nearest and the deepest base.
    pub(super) base: [u32; 2],
    shape: Shape,
}

#[derive(Clone)]
enum Shape {
    Uniform,
    Leaf(Box<Leaf>),
    Node(Box<[Undecided; 16]>),
}

impl Undecided {
    /// Returns a block of unconstrained columns.
    pub(super) fn free() -> Self {
        Self::uniform([0, BESIDE_GRID])
    }

    pub(super) fn uniform(base: [u32; 2]) -> Self {
        Self { base, shape: Shape::Uniform }
    }

    /// Sorts a block of columns into as few depths as suffice.
    #[inline]
    pub(super) fn leaf(columns: &BlockColumns, arch: pulp::Arch) -> Self {
        let (base, leaf) = sort_columns(columns, arch);
        Self { base, shape: leaf.map_or(Shape::Uniform, |leaf| Shape::Leaf(Box::new(leaf))) }
    }

    /// Returns the number of leaves.
    pub(super) fn leaves(&self) -> u64 {
        match &self.shape {
            Shape::Uniform => 0,
            Shape::Leaf(_) => 1,
            Shape::Node(children) => children.iter().map(Self::leaves).sum(),
        }
    }

    /// Whether no column in the block has to switch.
    pub(super) fn is_endless(&self) -> bool {
        self.base[1] >= FREE_TO_END && matches!(self.shape, Shape::Uniform)
    }

    /// Builds a node over sixteen blocks, in the order `y·4 + x`.
    pub(super) fn over(children: [Self; 16]) -> Self {
        let bases = children.each_ref().map(|c| c.base);
        let all = intersection(bases);
        if holds_any(all) && children.iter().all(|c| matches!(c.shape, Shape::Uniform)) {
            return Self::uniform(all);
        }
        // At least one interval has an end; otherwise all of them would intersect.
        let base = most_shared(&bases).unwrap_or(all);
        Self { base, shape: Shape::Node(Box::new(children)) }
    }

    /// Chooses the depths of the block at `base`, from the root down, and drafts its shapes from the leaves
    /// up. Returns the index of its own shape. `None` if all columns switch at `base`.
    pub(super) fn draft(&self, base: u32, level: u32, draft: &mut ShapeSet) -> Option<u32> {
        match &self.shape {
            Shape::Uniform => None,
            Shape::Leaf(leaf) => Some(draft.leaf(leaf.encode(base, &mut [0; MOST_HALVES]))),
            Shape::Node(blocks) => {
                let children: Children<u32> = std::array::from_fn(|c| {
                    let child = &blocks[c];
                    if child.is_endless() {
                        return Child::Never;
                    }
                    let inherits = child.base[0] <= base && base <= child.base[1];
                    let own = if inherits { base } else { child.base[0] };
                    let delta = own.wrapping_sub(base);
                    match child.draft(own, level - NODE_LEVELS, draft) {
                        None => Child::Uniform(delta),
                        Some(shape) => Child::Shape { shape, delta },
                    }
                });
                Some(draft.node(level, &children))
            }
        }
    }
}
