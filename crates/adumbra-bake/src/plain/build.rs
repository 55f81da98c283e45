//! The plain builder: every texel of a root block is drawn, and min/max pyramids decide its cubes. Slow, and the
//! reference for the fast builder.

use crate::columns::capture::{CaptureBuffers, capture};
use crate::columns::rules::Columns;
use crate::plain::tile;
use crate::sink::limit::SwitchLimit;
use crate::store::{NodeState, NodeStore};
use crate::tiles::Tiles;
use crate::triangles::surface::TileSurfaces;

/// Buffers that a worker reuses from tile to tile.
#[derive(Default)]
pub(crate) struct PlainBuffers {
    buffers: CaptureBuffers,
    columns: Columns,
}

/// Builds the root cubes of a tile, nearest first.
pub(crate) fn build_root(
    tiles: &Tiles<'_>,
    limit: SwitchLimit,
    tile: usize,
    store: &NodeStore,
    worker: &mut PlainBuffers,
) -> Vec<NodeState> {
    let surfaces = TileSurfaces { casters: &tiles.casters, tile, grid: &tiles.grid };
    capture(&surfaces, &tiles.rules, tiles.rect(tile), &mut worker.buffers, &mut worker.columns);
    limit.cut(&mut worker.columns);
    tile::build_roots(&worker.columns, tiles.root_level, tiles.top_dims[2], store)
}
