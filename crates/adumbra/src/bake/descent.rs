//! The block descent: a quadtree of blocks over the light's plane, each with the list of surfaces near it. What the judge can
//! resolve is never sampled; only blocks that contours cross go down to texels.
//!
//! Cost: each surface is met once a block that it comes near and that is not resolved above; texels in number of about the
//! contours' length.

use std::sync::atomic::{AtomicBool, Ordering};

use super::block::{Block, BlockSurface};
use super::capture::{CaptureBuffers, TileRect, capture};
use super::casters::Casters;
use super::columns::{ColumnRules, Columns, FREE_TO_END};
use super::gather::gather;
use super::judge::{JudgeBuffers, Verdict, judge};
use super::leaf::{LeafBuffers, leaf_columns};
use super::plan::Plan;
use super::project::SUBTEXEL;
use super::sink::{BLOCK_SIDE, BlockColumns, BlockSink};
use super::surface::{Surface, Surfaces};
use crate::dag::SLAB_NODE_LEVEL;
use crate::error::{Error, Result};
use crate::light::LightGrid;
use crate::scene::Scene;
use crate::settings::Receivers;

/// What one thread reuses from block to block.
#[derive(Default)]
pub(super) struct DescentBuffers {
    /// Lists of surfaces, those of a block behind those of its parent.
    lists: Vec<u32>,
    judge: JudgeBuffers,
    leaf: LeafBuffers,
    capture: CaptureBuffers,
    columns: Columns,
    /// Texels that were looked at one by one.
    pub(super) drawn_texels: u64,
}

/// Bytes that a worker holds: the surfaces of the fullest root block, and their lists at every level.
pub(super) fn working_bytes(casters: &Casters<'_>, tiles: [u32; 3]) -> u64 {
    let fullest = (0..(tiles[0] * tiles[1]) as usize)
        .map(|tile| casters.in_tile(tile).iter().map(|&p| casters.triangles(p).len() as u64).sum::<u64>())
        .max()
        .unwrap_or_default();
    // Gathering holds them twice; a list is at most as long as its parent's, and most are far shorter.
    fullest * (2 * size_of::<BlockSurface>() as u64 + 32)
}

/// Builds root block `tile` of `plan` into `sink`.
///
/// # Errors
/// [`Error::Interrupted`] soon after `cancel` is set.
pub(super) fn build_root<S: BlockSink>(
    plan: &Plan<'_>,
    tile: usize,
    sink: &S,
    buffers: &mut DescentBuffers,
    cancel: &AtomicBool,
) -> Result<S::Block> {
    let surfaces = gather(&plan.casters, tile, &plan.grid);
    let rect = plan.tile_rect(tile);
    let descent = Descent {
        scene: plan.casters.scene,
        grid: &plan.grid,
        rules: &plan.rules,
        surfaces: &surfaces,
        reach: reach_outside(&plan.rules),
        sink,
        cancel,
    };
    buffers.lists.clear();
    buffers.lists.extend(0..surfaces.len() as u32);
    let block = Block { level: plan.root_level, x: rect.x, y: rect.y };
    descent.build(block, 0, buffers)
}

/// How far outside a block a surface may matter to its columns, in 1/256 texel.
fn reach_outside(rules: &ColumnRules) -> i64 {
    // The footprint of a texel at the border, and what snapping may have moved.
    ((rules.reach_texels() - 0.5) * SUBTEXEL as f64).ceil() as i64 + 2
}

struct Descent<'a, S> {
    scene: &'a Scene,
    grid: &'a LightGrid,
    rules: &'a ColumnRules,
    surfaces: &'a [BlockSurface],
    reach: i64,
    sink: &'a S,
    cancel: &'a AtomicBool,
}

/// Blocks of this level look whether they should stop.
const CANCEL_LEVEL: u32 = 8;

impl<S: BlockSink> Descent<'_, S> {
    /// The block whose surfaces are `buffers.lists[from..]`. As deep as the tree has levels.
    fn build(&self, block: Block, from: usize, buffers: &mut DescentBuffers) -> Result<S::Block> {
        let [width, height, depth] = self.grid.size;
        if block.x >= width || block.y >= height {
            return Ok(self.sink.uniform(block.level, [0, FREE_TO_END]));
        }
        if buffers.lists.len() == from {
            return Ok(self.sink.uniform(block.level, [depth, FREE_TO_END]));
        }
        if block.level >= CANCEL_LEVEL && self.cancel.load(Ordering::Relaxed) {
            return Err(Error::Interrupted);
        }
        let list = &buffers.lists[from..];
        if let Verdict::Resolved(interval) =
            judge(&block, self.surfaces, list, self.rules, &mut buffers.judge)
        {
            return Ok(self.sink.uniform(block.level, interval));
        }
        if block.level == SLAB_NODE_LEVEL {
            return Ok(self.leaf(block, from, buffers));
        }
        let to = buffers.lists.len();
        let mut quarters = Vec::with_capacity(4);
        for q in 0..4 {
            let quarter = block.quarter(q);
            let rect = quarter.snapped(self.reach);
            for place in from..to {
                let s = buffers.lists[place];
                if rect.touches(&self.surfaces[s as usize].surface.shape) {
                    buffers.lists.push(s);
                }
            }
            let built = self.build(quarter, to, buffers);
            buffers.lists.truncate(to);
            quarters.push(built?);
        }
        match <[S::Block; 4]>::try_from(quarters) {
            Ok(quarters) => Ok(self.sink.join(block.level, quarters)),
            Err(_) => unreachable!("four quarters were built"),
        }
    }

    fn leaf(&self, block: Block, from: usize, buffers: &mut DescentBuffers) -> S::Block {
        let side = BLOCK_SIDE as u32;
        let width = side.min(self.grid.size[0] - block.x);
        let height = side.min(self.grid.size[1] - block.y);
        buffers.drawn_texels += u64::from(width * height);
        let list = &buffers.lists[from..];
        if self.rules.receivers == Receivers::All {
            let row = 0xff >> (side - width);
            let inside = (0..height).fold(0_u64, |mask, y| mask | row << (8 * y));
            let place = (self.scene, self.grid, self.rules);
            let columns = leaf_columns(&block, inside, self.surfaces, list, place, &mut buffers.leaf);
            return self.sink.leaf(&columns);
        }
        let rect = TileRect { x: block.x, y: block.y, width, height };
        let near = Near { descent: self, list };
        capture(&near, self.rules, rect, &mut buffers.capture, &mut buffers.columns);
        self.sink.leaf(&BlockColumns::padded(&buffers.columns))
    }
}

/// The surfaces near one block.
struct Near<'a, S> {
    descent: &'a Descent<'a, S>,
    list: &'a [u32],
}

impl<S> Surfaces for Near<'_, S> {
    fn scene(&self) -> &Scene {
        self.descent.scene
    }

    fn grid(&self) -> &LightGrid {
        self.descent.grid
    }

    fn for_each(&self, mut visit: impl FnMut(&Surface)) {
        for &s in self.list {
            visit(&self.descent.surfaces[s as usize].surface);
        }
    }
}
