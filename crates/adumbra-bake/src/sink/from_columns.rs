//! Blocks of a sink from columns in memory.

use crate::columns::{BLOCK_SIDE, BlockColumns};
use crate::pack::choose::{holds_any, intersection};
use crate::sink::BlockSink;

/// Builds the block of 2^level columns a side that starts at a corner. `column(x, y)` = `[e, x]`, e <= x.
///
/// Cost: each column is evaluated once per level.
pub(crate) fn block_of<S: BlockSink>(
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
