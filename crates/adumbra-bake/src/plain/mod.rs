//! The plain builder: every texel of a root block is drawn. Slow, and the reference that the fast builder is tested
//! against.

#[cfg(test)]
pub(crate) mod agreement;
#[cfg(test)]
mod reference;

use crate::columns::Columns;
use crate::columns::capture::{CaptureBuffers, capture};
use crate::columns::rules::BESIDE_GRID;
use crate::sink::BlockSink;
use crate::sink::from_columns::block_of;
use crate::sink::limit::SwitchLimit;
use crate::tiles::Tiles;
use crate::triangles::surface::TileSurfaces;

/// Buffers that a worker reuses from tile to tile.
#[derive(Default)]
pub(crate) struct PlainBuffers {
    buffers: CaptureBuffers,
    columns: Columns,
}

/// Builds root block `tile` of `tiles` into `sink`. Unlike in the fast builder, a switch limit cuts each column by itself.
pub(crate) fn build_root<S: BlockSink>(
    tiles: &Tiles<'_>,
    limit: SwitchLimit,
    tile: usize,
    sink: &S,
    worker: &mut PlainBuffers,
) -> S::Block {
    let surfaces = TileSurfaces { casters: &tiles.casters, tile, grid: &tiles.grid };
    let columns = &mut worker.columns;
    capture(&surfaces, &tiles.rules, tiles.rect(tile), &mut worker.buffers, columns);
    limit.cut(columns);
    let column = |x: u32, y: u32| {
        if x >= columns.width || y >= columns.height {
            return [0, BESIDE_GRID];
        }
        let texel = (y * columns.width + x) as usize;
        [columns.e[texel], columns.x[texel]]
    };
    block_of(sink, &column, tiles.root_level, [0, 0])
}
