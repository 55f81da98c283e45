//! The plain builder: every texel of a root block is drawn, min/max pyramids decide its cubes. Slow, and the judge of the
//! fast one.

use super::capture::{CaptureBuffers, capture};
use super::columns::Columns;
use super::plan::Plan;
use super::surface::TileSurfaces;
use super::tile;
use crate::dag::store::{NodeState, NodeStore};

/// What one thread reuses from tile to tile.
#[derive(Default)]
pub(super) struct PlainBuffers {
    buffers: CaptureBuffers,
    columns: Columns,
}

/// The root cubes of a tile, nearest first.
pub(super) fn build_root(
    plan: &Plan<'_>,
    tile: usize,
    store: &NodeStore,
    worker: &mut PlainBuffers,
) -> Vec<NodeState> {
    let surfaces = TileSurfaces { casters: &plan.casters, tile, grid: &plan.grid };
    capture(&surfaces, &plan.rules, plan.tile_rect(tile), &mut worker.buffers, &mut worker.columns);
    plan.early().cut(&mut worker.columns);
    tile::build_roots(&worker.columns, plan.root_level, plan.top_dims[2], store)
}
