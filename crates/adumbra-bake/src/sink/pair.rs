//! Two structures built in one traversal.

use super::BlockSink;
use crate::columns::BlockColumns;

/// Two sinks that both receive every block.
pub(crate) struct Pair<A, B>(pub(crate) A, pub(crate) B);

impl<A: BlockSink, B: BlockSink> BlockSink for Pair<A, B> {
    type Block = (A::Block, B::Block);

    fn uniform(&self, level: u32, interval: [u32; 2]) -> Self::Block {
        (self.0.uniform(level, interval), self.1.uniform(level, interval))
    }

    fn leaf(&self, columns: &BlockColumns) -> Self::Block {
        (self.0.leaf(columns), self.1.leaf(columns))
    }

    fn join(&self, level: u32, quarters: [Self::Block; 4]) -> Self::Block {
        let [(a0, b0), (a1, b1), (a2, b2), (a3, b3)] = quarters;
        (self.0.join(level, [a0, a1, a2, a3]), self.1.join(level, [b0, b1, b2, b3]))
    }
}
