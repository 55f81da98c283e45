//! From blocks of columns to a hierarchy, bottom up: intervals are intersected on the way up, and at a root depths are chosen top down.
//!
//! Where a depth is free it is the nearest: the first surface, which penumbrae want.
//!
//! A root's shapes depend on its columns alone, so neither threads nor their order matter. Held until a root is done: its own
//! undecided blocks; after it: the shapes that no root before had.

use std::sync::{Arc, Mutex};

use super::choose::{BESIDE_GRID, FREE_TO_END, holds_any, intersection, most_shared};
use super::leaf::{Leaf, sort_columns};
use super::store::{INHERITS, NEVER, OWN, SHARES, ShapeStore};
use super::{Hierarchy, LEAF_LEVEL, NODE_LEVELS, UNIFORM, encode};
use crate::bake::sink::{BlockColumns, BlockSink};
use crate::paged::Spill;

/// Half-words above which no more roots are taken.
const MOST_HALVES: u64 = (1 << 32) - (1 << 28);
/// Largest level of a hierarchy's roots.
const MAX_ROOT_LEVEL: u32 = 9;

/// Builds a [`Hierarchy`] from blocks.
pub(crate) struct HierarchySink {
    root_level: u32,
    /// Whether equal shapes are one.
    merged: bool,
    store: Mutex<ShapeStore>,
}

/// A finished block.
pub(crate) struct HierarchyBlock(Parts);

enum Parts {
    /// All of it, at a level that nodes have, or all alike.
    One(Undecided),
    /// Its quarters, at a level between those.
    Four(Box<[Undecided; 4]>),
    /// Above the roots: what the roots became, in the quarters' order at every level.
    Roots(Vec<[u32; 2]>),
}

/// A block whose base may still be any depth of an interval.
struct Undecided {
    base: [u32; 2],
    shape: Shape,
}

enum Shape {
    Uniform,
    Leaf(Box<Leaf>),
    Node(Box<[Undecided; 16]>),
}

impl HierarchyBlock {
    /// A block below the roots, at a level that nodes have.
    fn whole(self) -> Undecided {
        match self.0 {
            Parts::One(block) => block,
            Parts::Four(_) | Parts::Roots(_) => {
                unreachable!("only levels between nodes' are held in quarters")
            }
        }
    }

    /// The quarters of a block below the roots, at a level between those of nodes.
    fn quarters(self) -> [Undecided; 4] {
        match self.0 {
            Parts::Four(quarters) => *quarters,
            Parts::One(all) => [all.base; 4].map(Undecided::uniform),
            Parts::Roots(_) => unreachable!("roots are not quarters of nodes"),
        }
    }
}

impl Undecided {
    /// Columns that may be anything.
    fn free() -> Self {
        Self::uniform([0, BESIDE_GRID])
    }

    fn uniform(base: [u32; 2]) -> Self {
        Self { base, shape: Shape::Uniform }
    }

    /// Nothing in it must ever switch.
    fn is_endless(&self) -> bool {
        self.base[1] >= FREE_TO_END && matches!(self.shape, Shape::Uniform)
    }

    /// A node over sixteen blocks, `y·4 + x`.
    fn over(children: [Self; 16]) -> Self {
        let bases = children.each_ref().map(|c| c.base);
        let all = intersection(bases);
        if holds_any(all) && children.iter().all(|c| matches!(c.shape, Shape::Uniform)) {
            return Self::uniform(all);
        }
        // One at least ends, or all would have met.
        let base = most_shared(&bases).unwrap_or(all);
        Self { base, shape: Shape::Node(Box::new(children)) }
    }
}

impl HierarchySink {
    /// For a bake whose own roots have `root_level`, at least 5. `merged`: equal shapes are kept once. Shapes
    /// go to `spill`, if there is one.
    pub(crate) fn new(root_level: u32, merged: bool, spill: Option<&Arc<Spill>>) -> Self {
        let level = root_level.min(MAX_ROOT_LEVEL);
        let root_level = level - (level - LEAF_LEVEL) % NODE_LEVELS;
        Self { root_level, merged, store: Mutex::new(ShapeStore::new(spill)) }
    }

    /// Bytes held of roots that are done, beside what is paged.
    pub(crate) fn memory_bytes(&self) -> u64 {
        self.lock().memory_bytes()
    }

    /// Bytes of the shapes, wherever they are.
    pub(crate) fn shape_bytes(&self) -> u64 {
        2 * self.lock().halves() as u64
    }

    /// That addresses can tell all half-words apart, with room for what the roots at work add.
    ///
    /// # Errors
    /// [`Error::TooManyWords`](crate::Error::TooManyWords).
    pub(crate) fn check_room(&self) -> crate::Result<()> {
        if self.lock().halves() as u64 > MOST_HALVES {
            return Err(crate::Error::TooManyWords { what: "the hierarchy" });
        }
        Ok(())
    }

    /// Bytes that [`HierarchySink::finish`] needs beside the shapes: five numbers for each, and the result twice.
    pub(crate) fn finish_bytes(&self) -> u64 {
        let store = self.lock();
        20 * store.shapes() as u64 + 4 * store.halves() as u64
    }

    /// The hierarchy of a grid of `size` voxels from blocks of `level`, the bake's root level; x fastest.
    pub(crate) fn finish(self, size: [u32; 3], level: u32, blocks: Vec<HierarchyBlock>) -> Hierarchy {
        let side = 1 << (level - self.root_level);
        let top_dims = [size[0], size[1]].map(|n| n.div_ceil(1 << self.root_level));
        let across = size[0].div_ceil(1 << level);
        let mut top = vec![[UNIFORM, super::NEVER]; (top_dims[0] * top_dims[1]) as usize];
        for (b, block) in blocks.into_iter().enumerate() {
            let roots = self.roots(level, block);
            let (bx, by) = (b as u32 % across * side, b as u32 / across * side);
            for (r, root) in roots.into_iter().enumerate() {
                // Quarter x_bit << 1 | y_bit at every level.
                let bit = |shift: u32| {
                    (0..level - self.root_level).fold(0, |c, l| c | (r as u32 >> (2 * l + shift) & 1) << l)
                };
                let (x, y) = (bx + bit(1), by + bit(0));
                if x < top_dims[0] && y < top_dims[1] {
                    top[(y * top_dims[0] + x) as usize] = root;
                }
            }
        }
        let mut store = self.store.into_inner().unwrap_or_else(|e| e.into_inner());
        store.seal();
        let (top, wide, code) = encode::encode(&store, self.root_level, top);
        Hierarchy { size, root_level: self.root_level, top_dims, top, wide, code }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, ShapeStore> {
        self.store.lock().unwrap_or_else(|e| e.into_inner())
    }

    /// Whether blocks of a level are nodes or leaves.
    fn is_node_level(level: u32) -> bool {
        (level - LEAF_LEVEL).is_multiple_of(NODE_LEVELS)
    }

    /// A root's index and base.
    fn decide_root(&self, block: &Undecided) -> [u32; 2] {
        if block.is_endless() {
            return [UNIFORM, super::NEVER];
        }
        let base = block.base[0];
        let mut deciding = Deciding { store: &mut self.lock(), merged: self.merged, halves: Vec::new() };
        [deciding.shape(block, base, self.root_level), base]
    }

    fn roots(&self, level: u32, block: HierarchyBlock) -> Vec<[u32; 2]> {
        match block.0 {
            Parts::Roots(roots) => roots,
            Parts::One(all) => vec![self.decide_root(&all); 1 << (2 * (level - self.root_level))],
            Parts::Four(quarters) => quarters.iter().map(|q| self.decide_root(q)).collect(),
        }
    }

    /// A block of its level in its form: roots are decided at once.
    fn settle(&self, level: u32, block: Undecided) -> HierarchyBlock {
        HierarchyBlock(if level == self.root_level {
            Parts::Roots(vec![self.decide_root(&block)])
        } else {
            Parts::One(block)
        })
    }
}

impl BlockSink for HierarchySink {
    type Block = HierarchyBlock;

    fn uniform(&self, level: u32, interval: [u32; 2]) -> HierarchyBlock {
        let block = Undecided::uniform(interval);
        if level > self.root_level {
            let roots = 1 << (2 * (level - self.root_level));
            return HierarchyBlock(Parts::Roots(vec![self.decide_root(&block); roots]));
        }
        self.settle(level, block)
    }

    #[inline(never)] // Counted by `cargo xtask count`.
    fn leaf(&self, columns: &BlockColumns) -> HierarchyBlock {
        let (base, leaf) = sort_columns(columns);
        let shape = leaf.map_or(Shape::Uniform, |leaf| Shape::Leaf(Box::new(leaf)));
        self.settle(LEAF_LEVEL, Undecided { base, shape })
    }

    fn join(&self, level: u32, quarters: [HierarchyBlock; 4]) -> HierarchyBlock {
        if level > self.root_level {
            let roots = quarters.into_iter().flat_map(|q| self.roots(level - 1, q)).collect();
            return HierarchyBlock(Parts::Roots(roots));
        }
        if !Self::is_node_level(level) {
            return HierarchyBlock(Parts::Four(Box::new(quarters.map(HierarchyBlock::whole))));
        }
        let mut children: [Undecided; 16] = std::array::from_fn(|_| Undecided::free());
        for (quarter, block) in quarters.into_iter().enumerate() {
            for (part, block) in block.quarters().into_iter().enumerate() {
                let (x, y) = ((quarter >> 1) * 2 + (part >> 1), (quarter & 1) * 2 + (part & 1));
                children[y * 4 + x] = block;
            }
        }
        self.settle(level, Undecided::over(children))
    }
}

/// Choosing depths from the root down, and taking shapes into the store from the leaves up.
struct Deciding<'s> {
    store: &'s mut ShapeStore,
    merged: bool,
    halves: Vec<u16>,
}

impl Deciding<'_> {
    /// Index of a block's shape at `base`, or [`UNIFORM`].
    fn shape(&mut self, block: &Undecided, base: u32, level: u32) -> u32 {
        match &block.shape {
            Shape::Uniform => UNIFORM,
            Shape::Leaf(leaf) => {
                leaf.encode(base, &mut self.halves);
                self.store.leaves.intern(&self.halves, self.merged)
            }
            Shape::Node(children) => {
                let mut words = [0; 33];
                let mut length = 1;
                let mut push = |word| {
                    words[length] = word;
                    length += 1;
                };
                let mut states = 0;
                for (c, child) in children.iter().enumerate() {
                    let inherits = child.base[0] <= base && base <= child.base[1];
                    let state = if child.is_endless() {
                        NEVER
                    } else if !inherits {
                        let own = child.base[0];
                        push(own.wrapping_sub(base));
                        push(self.shape(child, own, level - NODE_LEVELS));
                        OWN
                    } else if matches!(child.shape, Shape::Uniform) {
                        INHERITS
                    } else {
                        push(self.shape(child, base, level - NODE_LEVELS));
                        SHARES
                    };
                    states |= state << (2 * c);
                }
                words[0] = states;
                let arena = ((level - LEAF_LEVEL) / NODE_LEVELS - 1) as usize;
                self.store.nodes[arena].intern(&words[..length], self.merged)
            }
        }
    }
}
