//! Depths from columns in memory, whatever their source.

use crate::columns::rules::BESIDE_GRID;
use crate::columns::{BLOCK_SIDE, BlockColumns};
use crate::pack::depths::choose::{holds_any, intersection};
use crate::sink::BlockSink;
use crate::sink::depths::DepthsSink;
use adumbra::layout::depths::DepthTree;

/// Builds depths from `column(i, j)` = `[e, x]`, e <= x, for each column of a grid of `size` voxels: the column may
/// switch from lit to shadowed at any depth from e to x, and may also never switch if x = `u32::MAX`. `root_level` is
/// that of the bake, at least 5. `merged`: equal shapes are stored once.
///
/// Cost: each column is evaluated once per level, on one thread.
pub(crate) fn depths_of_columns(
    size: [u32; 3],
    root_level: u32,
    merged: bool,
    column: impl Fn(u32, u32) -> [u32; 2],
) -> DepthTree {
    let level = root_level.max(5);
    let sink = DepthsSink::new(level, merged, None);
    let inside = |i, j| if i < size[0] && j < size[1] { column(i, j) } else { [0, BESIDE_GRID] };
    let corners = |n: u32| (0..n).step_by(1 << level);
    let block = |(y, x)| block_of(&sink, &inside, level, [x, y]);
    let blocks = corners(size[1]).flat_map(|y| corners(size[0]).map(move |x| (y, x))).map(block).collect();
    sink.finish(size, level, blocks)
}

/// Builds the block of columns that starts at a corner, recursively.
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
