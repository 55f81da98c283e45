//! The fast bake into the hierarchy, in place of the graph.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;

use super::descent::{self, DescentBuffers};
use super::plan::Plan;
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
    let sink = HierarchySink::new(plan.root_level, merged);
    let (accounted, drawn_texels, done) = (AtomicU64::new(0), AtomicU64::new(0), AtomicUsize::new(0));
    let finished_tile = || -> Result<()> {
        let store_bytes = sink.memory_bytes();
        let held = plan.scene_bytes + plan.workers as u64 * plan.worker_bytes + store_bytes;
        accounted.fetch_max(held, Ordering::Relaxed);
        plan.check_memory("the hierarchy so far", held)?;
        progress(Progress {
            done_tiles: done.fetch_add(1, Ordering::Relaxed) + 1,
            total_tiles: plan.tiles(),
            texels_per_tile: 1 << (2 * plan.root_level),
            graph_bytes: store_bytes,
        });
        Ok(())
    };
    let run = Run { plan: &plan, cancel, finished_tile: &finished_tile };
    let blocks = run.each_tile(|worker: &mut DescentBuffers, tile| {
        worker.drawn_texels = 0;
        let block = descent::build_root(&plan, tile, &sink, worker, cancel);
        drawn_texels.fetch_add(worker.drawn_texels, Ordering::Relaxed);
        block
    })?;
    // Two numbers a shape, and the words.
    let held = plan.scene_bytes + 2 * sink.memory_bytes();
    plan.check_memory("numbering the hierarchy", held)?;
    let hierarchy = sink.finish(plan.grid.size, plan.root_level, blocks);
    Ok(BakedHierarchy {
        grid: plan.grid,
        settings: plan.settings,
        hierarchy,
        report: Report {
            seconds: start.elapsed().as_secs_f64(),
            tiles: plan.tiles(),
            threads: plan.workers,
            drawn_texels: drawn_texels.into_inner(),
            accounted_bytes: accounted.into_inner().max(held),
        },
    })
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
