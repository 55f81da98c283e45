//! Root blocks of a scene in any sink, and the columns that they must answer for: what tests of sinks are made of.

use std::sync::atomic::AtomicBool;

use super::capture::{CaptureBuffers, capture};
use super::columns::Columns;
use super::descent::{self, DescentBuffers};
use super::plan::Plan;
use super::sink::BlockSink;
use super::surface::TileSurfaces;
use super::{Options, Run};
use crate::error::Result;
use crate::light::LightGrid;
use crate::scene::Scene;

/// A bake before its first block.
pub(crate) struct Blocks<'s>(Plan<'s>);

impl<'s> Blocks<'s> {
    pub(crate) fn new(scene: &'s Scene, options: &Options) -> Result<Self> {
        Ok(Self(Plan::new(scene, options)?))
    }

    pub(crate) fn grid(&self) -> LightGrid {
        self.0.grid
    }

    pub(crate) fn root_level(&self) -> u32 {
        self.0.root_level
    }

    /// Every root block by the fast builder, x fastest.
    pub(crate) fn into_sink<S: BlockSink>(&self, sink: &S) -> Result<Vec<S::Block>> {
        let cancel = AtomicBool::new(false);
        let run = Run { plan: &self.0, cancel: &cancel, finished_tile: &|| Ok(()) };
        run.each_tile(|worker: &mut DescentBuffers, tile| {
            descent::build_root(&self.0, tile, sink, worker, &cancel)
        })
    }

    /// Calls `visit(i, j, [e, x])` with every column, every texel drawn.
    pub(crate) fn for_each_column(&self, mut visit: impl FnMut(u32, u32, [u32; 2])) {
        let plan = &self.0;
        let (mut buffers, mut columns) = (CaptureBuffers::default(), Columns::default());
        for tile in 0..plan.tiles() {
            let rect = plan.tile_rect(tile);
            let surfaces = TileSurfaces { casters: &plan.casters, tile, grid: &plan.grid };
            capture(&surfaces, &plan.rules, rect, &mut buffers, &mut columns);
            for at in 0..columns.e.len() as u32 {
                let (i, j) = (rect.x + at % rect.width, rect.y + at / rect.width);
                visit(i, j, [columns.e[at as usize], columns.x[at as usize]]);
            }
        }
    }
}
