//! The plain builder: every texel of a root block is drawn. Slow, and the reference that the fast builder is
//! tested against.

#[cfg(test)]
pub(crate) mod agreement;
#[cfg(test)]
mod reference;

use crate::columns::Columns;
use crate::columns::capture::{CaptureBuffers, capture};
use crate::columns::rules::BESIDE_GRID;
use crate::root_blocks::RootBlocks;
use crate::sink::BlockSink;
use crate::sink::from_columns::block_of;
use crate::triangles::surface::BinSurfaces;

/// Buffers that a worker reuses from one root block to the next.
#[derive(Default)]
pub(crate) struct PlainBuffers {
    buffers: CaptureBuffers,
    columns: Columns,
}

/// Builds root block `root_block` of `root_blocks` into `sink`. Unlike in the fast builder, a switch limit
/// cuts each column by itself.
pub(crate) fn build_root<S: BlockSink>(
    root_blocks: &RootBlocks<'_>,
    root_block: usize,
    sink: &S,
    worker: &mut PlainBuffers,
) -> S::Block {
    let surfaces = BinSurfaces { casters: &root_blocks.casters, bin: root_block, grid: &root_blocks.grid };
    let columns = &mut worker.columns;
    capture(&surfaces, &root_blocks.rules, root_blocks.rect(root_block), &mut worker.buffers, columns);
    root_blocks.limit.cut(&columns.e, &mut columns.x);
    let column = |x: u32, y: u32| {
        if x >= columns.width || y >= columns.height {
            return [0, BESIDE_GRID];
        }
        let texel = (y * columns.width + x) as usize;
        [columns.e[texel], columns.x[texel]]
    };
    block_of(sink, &column, root_blocks.root_level, [0, 0])
}
