//! The fast bake into the hierarchy, in place of the graph.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::plan::Plan;
use super::tally::Tally;
use super::{Options, Progress, Report, Run};
use crate::error::Result;
use crate::hierarchy::Hierarchy;
use crate::hierarchy::sink::HierarchySink;
use crate::light::LightGrid;
use crate::scene::Scene;
use crate::settings::Settings;

/// A finished bake.
#[derive(Debug)]
pub struct BakedHierarchy {
    /// Where the grid lies.
    pub grid: LightGrid,
    /// What was asked for.
    pub settings: Settings,
    /// The answers.
    pub hierarchy: Hierarchy,
    /// How it went.
    pub report: Report,
}

/// Bakes `scene` as [`super::bake`] does, by the fast builder whatever `options` say. `merged`: equal shapes are kept once.
///
/// # Errors
/// As [`super::bake`].
pub fn bake_hierarchy(
    scene: &Scene,
    options: &Options,
    merged: bool,
    progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<BakedHierarchy> {
    let start = Instant::now();
    let plan = Plan::new(scene, &Options { builder: super::Builder::Fast, ..options.clone() })?;
    let tally = Tally::new(&plan, start, progress);
    let sink = HierarchySink::new(plan.root_level, merged, plan.spill.as_ref());
    let finished_tile = || {
        sink.check_room()?;
        tally.finished_tile("the hierarchy so far", sink.memory_bytes(), sink.shape_bytes())
    };
    let run = Run { plan: &plan, cancel, finished_tile: &finished_tile };
    let blocks = run.each_block(&sink, &tally)?;
    tally.check_end("numbering the hierarchy", sink.memory_bytes() + sink.finish_bytes())?;
    let hierarchy = sink.finish(plan.grid.size, plan.root_level, blocks);
    plan.paged_bytes()?;
    Ok(BakedHierarchy { grid: plan.grid, settings: plan.settings, hierarchy, report: tally.report() })
}

/// Calls `visit(i, j, [e, x])` with every column that a bake must answer for, every texel drawn.
#[cfg(test)]
pub(crate) fn for_each_column(
    scene: &Scene,
    options: &Options,
    mut visit: impl FnMut(u32, u32, [u32; 2]),
) -> Result<()> {
    let plan = Plan::new(scene, &Options { builder: super::Builder::Plain, ..options.clone() })?;
    let mut buffers = super::capture::CaptureBuffers::default();
    let mut columns = super::columns::Columns::default();
    for tile in 0..plan.tiles() {
        let rect = plan.tile_rect(tile);
        let surfaces = super::surface::TileSurfaces { casters: &plan.casters, tile, grid: &plan.grid };
        super::capture::capture(&surfaces, &plan.rules, rect, &mut buffers, &mut columns);
        for at in 0..columns.e.len() as u32 {
            let (i, j) = (rect.x + at % rect.width, rect.y + at / rect.width);
            visit(i, j, [columns.e[at as usize], columns.x[at as usize]]);
        }
    }
    Ok(())
}
