//! A hierarchy from columns that are at hand, whoever made them.

use super::Hierarchy;
use super::choose::{BESIDE_GRID, holds_any, intersection};
use super::sink::HierarchySink;
use crate::bake::sink::{BLOCK_SIDE, BlockColumns, BlockSink};

impl Hierarchy {
    /// From `column(i, j)` = `[e, x]`, e <= x, for each column of a grid of `size` voxels: it may switch from lit to shadowed at any depth
    /// from e to x; x = `u32::MAX`: or never. `root_level` is the bake's, 5 or more. `merged`: equal shapes are kept once.
    ///
    /// Cost: each column is asked once a level, on one thread.
    pub(super) fn from_columns(
        size: [u32; 3],
        root_level: u32,
        merged: bool,
        column: impl Fn(u32, u32) -> [u32; 2],
    ) -> Self {
        let level = root_level.max(5);
        let sink = HierarchySink::new(level, merged, None);
        let inside = |i, j| if i < size[0] && j < size[1] { column(i, j) } else { [0, BESIDE_GRID] };
        let corners = |n: u32| (0..n).step_by(1 << level);
        let block = |(y, x)| block_of(&sink, &inside, level, [x, y]);
        let blocks =
            corners(size[1]).flat_map(|y| corners(size[0]).map(move |x| (y, x))).map(block).collect();
        sink.finish(size, level, blocks)
    }
}

/// The block of columns from this corner on, and of the blocks in it, as a sink has them.
fn block_of<S: BlockSink>(
    sink: &S,
    column: &impl Fn(u32, u32) -> [u32; 2],
    level: u32,
    [x, y]: [u32; 2],
) -> S::Block {
    let side = 1 << level;
    let all = intersection((y..y + side).flat_map(|j| (x..x + side).map(move |i| column(i, j))));
    if holds_any(all) {
        return sink.uniform(level, all);
    }
    if side as usize > BLOCK_SIDE {
        let half = side / 2;
        let quarter = |q: u32| block_of(sink, column, level - 1, [x + (q >> 1) * half, y + (q & 1) * half]);
        return sink.join(level, [0, 1, 2, 3].map(quarter));
    }
    let interval = |at: usize| column(x + at as u32 % 8, y + at as u32 / 8);
    sink.leaf(&BlockColumns {
        e: std::array::from_fn(|at| interval(at)[0]),
        x: std::array::from_fn(|at| interval(at)[1]),
    })
}
