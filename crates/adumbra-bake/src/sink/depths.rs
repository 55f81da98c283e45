//! Builds a quadtree of depths from blocks of columns, bottom up. Intervals are intersected on the way up; at a root,
//! depths are chosen top down.
//!
//! Where a depth is free, the nearest one is chosen: the first surface, which penumbrae need.
//!
//! A root's shapes depend on its columns alone, so neither the number of threads nor their order matters. Until a root
//! is done, its own undecided blocks are held; after that, the shapes that no earlier root had.

use std::sync::{Arc, Mutex};

use crate::columns::BlockColumns;
use crate::columns::rules::{BESIDE_GRID, FREE_TO_END};
use crate::pack::choose::{holds_any, intersection, most_shared};
use crate::pack::encode;
use crate::pack::leaf::{Leaf, sort_columns};
use crate::sink::{BlockSink, Structure};
use crate::store::paged::Spill;
use crate::store::shapes::{INHERITS, NEVER, OWN, SHARES, ShapeStore};
use adumbra::layout::depths::{DepthTree, LEAF_LEVEL, NODE_LEVELS, UNIFORM};

/// Number of half-words above which no more roots are accepted.
const MAX_HALVES: u64 = (1 << 32) - (1 << 28);
/// Largest level of the roots.
const MAX_ROOT_LEVEL: u32 = 9;

/// Builds a [`DepthTree`] from blocks.
pub struct DepthsSink {
    root_level: u32,
    /// Whether equal shapes are stored once.
    merged: bool,
    /// The processor's vectors.
    arch: pulp::Arch,
    store: Mutex<ShapeStore>,
}

/// A finished block.
pub struct DepthsBlock(Parts);

enum Parts {
    /// The whole block, at a level that nodes have, or uniform at any level.
    One(Undecided),
    /// Four quarters, at a level between two node levels.
    Four(Box<[Undecided; 4]>),
    /// Above the roots: what the roots became, with the quarters' order at every level.
    Roots(Vec<[u32; 2]>),
}

/// A block whose base may still be any depth in an interval.
struct Undecided {
    base: [u32; 2],
    shape: Shape,
}

enum Shape {
    Uniform,
    Leaf(Box<Leaf>),
    Node(Box<[Undecided; 16]>),
}

impl DepthsBlock {
    /// Returns a block below the roots whose level nodes have.
    fn whole(self) -> Undecided {
        match self.0 {
            Parts::One(block) => block,
            Parts::Four(_) | Parts::Roots(_) => {
                unreachable!("only levels between node levels are held in quarters")
            }
        }
    }

    /// Returns the quarters of a block below the roots whose level is between those of nodes.
    fn quarters(self) -> [Undecided; 4] {
        match self.0 {
            Parts::Four(quarters) => *quarters,
            Parts::One(all) => [all.base; 4].map(Undecided::uniform),
            Parts::Roots(_) => unreachable!("roots are not quarters of nodes"),
        }
    }
}

impl Undecided {
    /// Returns a block of columns that may be anything.
    fn free() -> Self {
        Self::uniform([0, BESIDE_GRID])
    }

    fn uniform(base: [u32; 2]) -> Self {
        Self { base, shape: Shape::Uniform }
    }

    /// Whether no column in the block must ever switch.
    fn is_endless(&self) -> bool {
        self.base[1] >= FREE_TO_END && matches!(self.shape, Shape::Uniform)
    }

    /// Builds a node over sixteen blocks, in the order `y·4 + x`.
    fn over(children: [Self; 16]) -> Self {
        let bases = children.each_ref().map(|c| c.base);
        let all = intersection(bases);
        if holds_any(all) && children.iter().all(|c| matches!(c.shape, Shape::Uniform)) {
            return Self::uniform(all);
        }
        // At least one has an end; otherwise the intervals would all intersect.
        let base = most_shared(&bases).unwrap_or(all);
        Self { base, shape: Shape::Node(Box::new(children)) }
    }
}

/// Returns the bytes of what this many root blocks of `level` become, and of the top grid.
pub(crate) fn top_bytes(blocks: u64, level: u32) -> u64 {
    let roots = blocks << (2 * (level - tree_root_level(level)));
    // Index and base of each root, in its block and in the top grid.
    blocks * size_of::<DepthsBlock>() as u64 + 2 * roots * size_of::<[u32; 2]>() as u64
}

/// Returns the level of the tree's roots for a bake whose own roots have this one.
fn tree_root_level(level: u32) -> u32 {
    let level = level.min(MAX_ROOT_LEVEL);
    level - (level - LEAF_LEVEL) % NODE_LEVELS
}

impl DepthsSink {
    /// Creates a sink in memory for a bake whose own roots have `root_level`, at least 5. `merged`: equal shapes are
    /// stored once, as in every file.
    pub fn in_memory(root_level: u32, merged: bool) -> Self {
        Self::new(root_level, merged, None)
    }

    /// Creates a sink whose shapes go to `spill`, if there is one. See [`DepthsSink::in_memory`].
    pub(crate) fn new(root_level: u32, merged: bool, spill: Option<&Arc<Spill>>) -> Self {
        let root_level = tree_root_level(root_level);
        Self { root_level, merged, arch: pulp::Arch::new(), store: Mutex::new(ShapeStore::new(spill)) }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, ShapeStore> {
        self.store.lock().unwrap_or_else(|e| e.into_inner())
    }

    /// Whether blocks of this level are nodes or leaves.
    fn is_node_level(level: u32) -> bool {
        (level - LEAF_LEVEL).is_multiple_of(NODE_LEVELS)
    }

    /// Decides a root, and returns its index and base.
    fn decide_root(&self, block: &Undecided) -> [u32; 2] {
        if block.is_endless() {
            return [UNIFORM, adumbra::layout::depths::NEVER];
        }
        let base = block.base[0];
        let mut deciding = Deciding { store: &mut self.lock(), merged: self.merged, halves: Vec::new() };
        [deciding.shape(block, base, self.root_level), base]
    }

    fn roots(&self, level: u32, block: DepthsBlock) -> Vec<[u32; 2]> {
        match block.0 {
            Parts::Roots(roots) => roots,
            Parts::One(all) => vec![self.decide_root(&all); 1 << (2 * (level - self.root_level))],
            Parts::Four(quarters) => quarters.iter().map(|q| self.decide_root(q)).collect(),
        }
    }

    /// Wraps a block. Roots are decided at once.
    fn resolve(&self, level: u32, block: Undecided) -> DepthsBlock {
        DepthsBlock(if level == self.root_level {
            Parts::Roots(vec![self.decide_root(&block)])
        } else {
            Parts::One(block)
        })
    }
}

impl BlockSink for DepthsSink {
    type Block = DepthsBlock;

    fn uniform(&self, level: u32, interval: [u32; 2]) -> DepthsBlock {
        let block = Undecided::uniform(interval);
        if level > self.root_level {
            let roots = 1 << (2 * (level - self.root_level));
            return DepthsBlock(Parts::Roots(vec![self.decide_root(&block); roots]));
        }
        self.resolve(level, block)
    }

    #[inline(never)] // Counted by `cargo xtask count`.
    fn leaf(&self, columns: &BlockColumns) -> DepthsBlock {
        let (base, leaf) = sort_columns(columns, self.arch);
        let shape = leaf.map_or(Shape::Uniform, |leaf| Shape::Leaf(Box::new(leaf)));
        self.resolve(LEAF_LEVEL, Undecided { base, shape })
    }

    fn join(&self, level: u32, quarters: [DepthsBlock; 4]) -> DepthsBlock {
        if level > self.root_level {
            let roots = quarters.into_iter().flat_map(|q| self.roots(level - 1, q)).collect();
            return DepthsBlock(Parts::Roots(roots));
        }
        if !Self::is_node_level(level) {
            return DepthsBlock(Parts::Four(Box::new(quarters.map(DepthsBlock::whole))));
        }
        let mut children: [Undecided; 16] = std::array::from_fn(|_| Undecided::free());
        for (quarter, block) in quarters.into_iter().enumerate() {
            for (part, block) in block.quarters().into_iter().enumerate() {
                let (x, y) = ((quarter >> 1) * 2 + (part >> 1), (quarter & 1) * 2 + (part & 1));
                children[y * 4 + x] = block;
            }
        }
        self.resolve(level, Undecided::over(children))
    }
}

impl Structure for DepthsSink {
    type Made = DepthTree;
    const SO_FAR: &'static str = "the depths so far";
    const FINISHING: &'static str = "numbering the depths";

    fn memory_bytes(&self) -> u64 {
        self.lock().memory_bytes()
    }

    fn result_bytes(&self) -> u64 {
        2 * self.lock().halves() as u64
    }

    /// Five numbers per shape, and twice the result.
    fn finish_bytes(&self) -> u64 {
        let store = self.lock();
        20 * store.shapes() as u64 + 4 * store.halves() as u64
    }

    fn check_room(&self) -> crate::Result<()> {
        if self.lock().halves() as u64 > MAX_HALVES {
            return Err(crate::Error::TooManyWords { what: "the quadtree of depths" });
        }
        Ok(())
    }

    fn finish(self, size: [u32; 3], level: u32, blocks: Vec<DepthsBlock>) -> DepthTree {
        let side = 1 << (level - self.root_level);
        let top_dims = [size[0], size[1]].map(|n| n.div_ceil(1 << self.root_level));
        let across = size[0].div_ceil(1 << level);
        let mut top = vec![[UNIFORM, adumbra::layout::depths::NEVER]; (top_dims[0] * top_dims[1]) as usize];
        for (b, block) in blocks.into_iter().enumerate() {
            let roots = self.roots(level, block);
            let (bx, by) = (b as u32 % across * side, b as u32 / across * side);
            for (r, root) in roots.into_iter().enumerate() {
                // Quarters are numbered x_bit << 1 | y_bit at every level.
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
        DepthTree { size, root_level: self.root_level, top_dims, top, wide, code }
    }
}

/// Chooses depths from the root down, and adds shapes to the store from the leaves up.
struct Deciding<'s> {
    store: &'s mut ShapeStore,
    merged: bool,
    halves: Vec<u16>,
}

impl Deciding<'_> {
    /// Returns the index of a block's shape at `base`, or [`UNIFORM`].
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
