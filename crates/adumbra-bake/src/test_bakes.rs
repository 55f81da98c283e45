//! Bakes that give the unit tests access to their voxels. Integration tests get theirs from `adumbra-testing`, whose
//! types belong to another build of this crate.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use adumbra::layout::depths::DepthTree;
use adumbra::layout::plain::Dag;
use adumbra::{FileSettings, LightBody, LightGrid};
use adumbra_scene::Scene;

use crate::bake::{depths, graph};
use crate::choose;
use crate::columns::capture::{CaptureBuffers, capture};
use crate::columns::rules::Columns;
use crate::error::Result;
use crate::options::{BakeOptions, Builder, LayoutChoice};
use crate::progress::{Report, Watch};
use crate::tally::Tally;
use crate::triangles::surface::TileSurfaces;

/// A bake in the plain layout, split into its parts.
pub(crate) struct BakedGraph {
    pub(crate) grid: LightGrid,
    pub(crate) settings: FileSettings,
    pub(crate) dag: Dag,
    pub(crate) report: Report,
}

/// Bakes the graph for `options`, whatever layout they name.
pub(crate) fn bake_graph(scene: &Scene, options: &BakeOptions) -> Result<BakedGraph> {
    let options = BakeOptions { layout: LayoutChoice::Plain, ..options.clone() };
    let baked = crate::bake(scene, &options, Watch::none())?;
    let LightBody::Plain(dag) = baked.file.body else { unreachable!("the plain layout was requested") };
    Ok(BakedGraph { grid: baked.file.grid, settings: baked.file.settings, dag, report: baked.report })
}

/// Bakes the depths for `options`, whatever layout they name. `merged`: equal shapes are stored once, as in every file.
pub(crate) fn bake_depths(scene: &Scene, options: &BakeOptions, merged: bool) -> Result<(DepthTree, Report)> {
    let plan = choose::plan(scene, &BakeOptions { builder: Builder::Fast, ..options.clone() })?;
    let tally = Tally::new(&plan, Instant::now(), &|_| {});
    let depths = depths::depths(&plan, &tally, merged, &AtomicBool::new(false))?;
    Ok((depths, tally.report()))
}

/// Bakes the graph and the depths from columns that are computed once.
pub(crate) fn bake_both(scene: &Scene, options: &BakeOptions) -> Result<((Dag, DepthTree), Report)> {
    let plan = choose::plan(scene, &BakeOptions { builder: Builder::Fast, ..options.clone() })?;
    let tally = Tally::new(&plan, Instant::now(), &|_| {});
    let both = graph::both(&plan, &tally, &AtomicBool::new(false))?;
    Ok((both, tally.report()))
}

/// Calls `visit(i, j, [e, x])` for every column of the grid. Every texel is drawn.
pub(crate) fn for_each_column(
    scene: &Scene,
    options: &BakeOptions,
    mut visit: impl FnMut(u32, u32, [u32; 2]),
) -> Result<()> {
    let plan = choose::plan(scene, &BakeOptions { builder: Builder::Plain, ..options.clone() })?;
    let tiles = &plan.tiles;
    let mut buffers = CaptureBuffers::default();
    let mut columns = Columns::default();
    for tile in 0..tiles.count() {
        let rect = tiles.rect(tile);
        let surfaces = TileSurfaces { casters: &tiles.casters, tile, grid: &tiles.grid };
        capture(&surfaces, &tiles.rules, rect, &mut buffers, &mut columns);
        for at in 0..columns.e.len() as u32 {
            let (i, j) = (rect.x + at % rect.width, rect.y + at / rect.width);
            visit(i, j, [columns.e[at as usize], columns.x[at as usize]]);
        }
    }
    Ok(())
}
