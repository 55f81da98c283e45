//! Bakes that give the unit tests access to their voxels and columns.

use adumbra::layout::depths::DepthTree;
use adumbra_scene::Scene;

use crate::bake::build_planned;
use crate::choose;
use crate::columns::Columns;
use crate::columns::capture::{CaptureBuffers, capture};
use crate::error::Result;
use crate::options::{BakeOptions, Builder};
use crate::progress::{Report, Watch};
use crate::sink::depths::DepthsSink;
use crate::tiles::Tiles;
use crate::triangles::surface::TileSurfaces;

/// Bakes the depths of the finest level for `options`. `merged`: equal shapes are stored once, as in every file.
pub(crate) fn bake_depths(scene: &Scene, options: &BakeOptions, merged: bool) -> Result<(DepthTree, Report)> {
    let plan = choose::plan(scene, options)?;
    let built = build_planned(&plan, options, Watch::none(), |plan| {
        DepthsSink::new(plan.tiles.grid.size, plan.tiles.root_level, merged, &plan.spill)
    })?;
    Ok((built.made.tree()?, built.report))
}

/// Calls `visit(i, j, [e, x])` for every column of the grid. Every texel is drawn.
pub(crate) fn for_each_column(
    scene: &Scene,
    options: &BakeOptions,
    visit: impl FnMut(u32, u32, [u32; 2]),
) -> Result<()> {
    let plan = choose::plan(scene, &BakeOptions { builder: Builder::Plain, ..options.clone() })?;
    for_each_column_of(&plan.tiles, visit);
    Ok(())
}

/// Calls `visit(i, j, [e, x])` for every column, root block by root block. Every texel is drawn.
pub(crate) fn for_each_column_of(tiles: &Tiles<'_>, mut visit: impl FnMut(u32, u32, [u32; 2])) {
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
}
