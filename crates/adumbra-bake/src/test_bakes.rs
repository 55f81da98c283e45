//! Bakes that give the unit tests access to their voxels and columns.

use adumbra::layout::depths::DepthTree;
use adumbra_scene::Scene;

use crate::bake::structure::build_planned;
use crate::choose;
use crate::columns::Columns;
use crate::columns::capture::{CaptureBuffers, capture};
use crate::error::Result;
use crate::options::{BakeOptions, ColumnBuilder};
use crate::progress::{Report, Watch};
use crate::root_blocks::RootBlocks;
use crate::sink::depths::DepthsSink;
use crate::triangles::surface::BinSurfaces;

/// Bakes the depths of the finest level for `options`. `merged`: equal shapes are stored once, as in every
/// file.
pub(crate) fn bake_depths(scene: &Scene, options: &BakeOptions, merged: bool) -> Result<(DepthTree, Report)> {
    let plan = choose::plan(scene, options)?;
    let built = build_planned(&plan, options, Watch::none(), |plan| {
        DepthsSink::new(plan.root_blocks.grid.size, plan.root_blocks.root_level, merged, &plan.spill)
    })?;
    Ok((built.made.tree()?, built.report))
}

/// Calls `visit(i, j, [e, x])` for every column of the grid. Every texel is drawn.
pub(crate) fn for_each_column(
    scene: &Scene,
    options: &BakeOptions,
    visit: impl FnMut(u32, u32, [u32; 2]),
) -> Result<()> {
    let plan = choose::plan(scene, &BakeOptions { builder: ColumnBuilder::Plain, ..options.clone() })?;
    for_each_column_of(&plan.root_blocks, visit);
    Ok(())
}

/// Calls `visit(i, j, [e, x])` for every column, root block by root block. Every texel is drawn.
pub(crate) fn for_each_column_of(root_blocks: &RootBlocks<'_>, mut visit: impl FnMut(u32, u32, [u32; 2])) {
    let mut buffers = CaptureBuffers::default();
    let mut columns = Columns::default();
    for root_block in 0..root_blocks.count() {
        let rect = root_blocks.rect(root_block);
        let surfaces =
            BinSurfaces { casters: &root_blocks.casters, bin: root_block, grid: &root_blocks.grid };
        capture(&surfaces, &root_blocks.rules, rect, &mut buffers, &mut columns);
        for at in 0..columns.e.len() as u32 {
            let (i, j) = (rect.x + at % rect.width, rect.y + at / rect.width);
            visit(i, j, [columns.e[at as usize], columns.x[at as usize]]);
        }
    }
}
