//! The table of blocks at which look-ups begin. A file has one root per page, 512 × 512 columns. Where the grid is small,
//! a table of smaller blocks costs little and saves the steps above them, so it is made when the file is read. No answer
//! depends on it.

use crate::layout::depths::code::Child;
use crate::layout::depths::page::PAGE_LEVEL;
use crate::layout::depths::{DepthTree, NEVER, NODE_LEVELS, UNIFORM};

/// Largest number of blocks of a table that is finer than pages: 64 KiB.
const MAX_FINE_BLOCKS: u64 = 1 << 13;
/// The levels that a table may have, finest first. They are those of nodes.
const LEVELS: [u32; 3] = [5, 7, PAGE_LEVEL];

/// A table of blocks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Top {
    /// A block spans 2^level columns along each side.
    pub(super) level: u32,
    /// Number of blocks along x and y.
    pub(super) dims: [u32; 2],
    /// Address of a block's node in the code, or [`UNIFORM`], and its base; x fastest.
    pub(super) entries: Vec<[u32; 2]>,
}

impl Top {
    /// Makes the table of a valid tree.
    pub(super) fn of(tree: &DepthTree) -> Self {
        let dims_of = |level: u32| [tree.size[0], tree.size[1]].map(|n| n.div_ceil(1 << level));
        let is_small = |level: u32| dims_of(level).map(u64::from).iter().product::<u64>() <= MAX_FINE_BLOCKS;
        let level = LEVELS.into_iter().find(|&level| is_small(level)).unwrap_or(PAGE_LEVEL);
        let dims = dims_of(level);
        let blocks = (0..dims[1]).flat_map(|y| (0..dims[0]).map(move |x| [x << level, y << level]));
        Self { level, dims, entries: blocks.map(|column| entry(tree, level, column)).collect() }
    }
}

/// Returns the entry of the block of `level` that contains a column.
fn entry(tree: &DepthTree, level: u32, [i, j]: [u32; 2]) -> [u32; 2] {
    let [mut at, mut base] = tree.root([i >> PAGE_LEVEL, j >> PAGE_LEVEL]);
    let mut reached = PAGE_LEVEL;
    while reached > level && at != UNIFORM {
        reached -= NODE_LEVELS;
        [at, base] = match tree.shapes().child(at, (j >> reached & 3) << 2 | i >> reached & 3) {
            Child::Never => [UNIFORM, NEVER],
            Child::Uniform(delta) => [UNIFORM, base.wrapping_add(delta)],
            Child::Shape { at, delta, .. } => [at, base.wrapping_add(delta)],
        };
    }
    [at, base]
}
