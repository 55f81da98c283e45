//! The block descent: a quadtree of blocks over the light's plane, each with the list of surfaces near it.
//! Blocks that classification resolves are never sampled. Only blocks that contours cross are subdivided down
//! to texels.
//!
//! Cost: each surface is visited once per block that it is near, unless an ancestor of the block was
//! resolved. The number of texels drawn is about the contours' length in texels.

use adumbra::layout::depths::LEAF_LEVEL;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::columns::Columns;
use crate::columns::capture::{CaptureBuffers, TexelRect, capture};
use crate::columns::limit::SwitchLimit;
use crate::columns::masked::TriangleMask;
use crate::columns::rules::{BESIDE_GRID, FREE_TO_END};
use crate::columns::{BLOCK_SIDE, BlockColumns};
use crate::error::{Error, Result};
use crate::fast::block::{Block, BlockSurface, SnappedBox};
use crate::fast::classify::{Classification, ClassifyBuffers, classify};
use crate::fast::gather::gather;
use crate::fast::leaf::{LazyMask, LeafBuffers, NearSurfaces, Setting, leaf_columns};
use crate::root_blocks::RootBlocks;
use crate::sink::BlockSink;
use crate::triangles::casters::Casters;
use crate::triangles::depth::{FixedDepth, SUBTEXEL};
use crate::triangles::surface::{Surface, Surfaces};
use adumbra::Receivers;
use adumbra::grid::LightGrid;
use adumbra_scene::{AlphaMode, Scene};

/// Buffers that a worker reuses from block to block.
#[derive(Default)]
pub(crate) struct DescentBuffers {
    /// Lists of surfaces. A block's list follows that of its parent.
    lists: Vec<u32>,
    /// Lists of receivers that are farther away, whose filters may read the block's columns.
    beside: Vec<u32>,
    classify: ClassifyBuffers,
    leaf: LeafBuffers,
    capture: CaptureBuffers,
    columns: Columns,
    /// Texels that were evaluated one by one.
    pub(crate) drawn_texels: u64,
}

impl DescentBuffers {
    /// Removes the surfaces behind `resolved`, and their ranges, from the list that was classified last.
    /// Those whose filters still read before it are moved to the list of farther receivers. Returns the
    /// nearest depth that look-ups from removed surfaces sample.
    fn forget_behind(
        &mut self,
        block: &Block,
        from: usize,
        resolved: FixedDepth,
        setting: &Setting<'_>,
    ) -> FixedDepth {
        let ranges = &mut self.classify.ranges;
        let mut nearest = FixedDepth::MAX;
        let mut kept = 0;
        for i in 0..ranges.len() {
            let s = self.lists[from + i];
            if ranges[i].is_behind(resolved) {
                nearest = nearest.min(ranges[i].lifted());
                let contacts = setting.surfaces[s as usize].contacts_over(block, None, setting.rules);
                if contacts.is_some_and(|[low, _]| low < setting.rules.latest_switch(resolved)) {
                    self.beside.push(s);
                }
            } else {
                self.lists[from + kept] = s;
                ranges[kept] = ranges[i];
                kept += 1;
            }
        }
        ranges.truncate(kept);
        self.lists.truncate(from + kept);
        nearest
    }
}

/// Returns the bytes that a worker holds: the surfaces of the fullest root block, and their lists at every
/// level.
pub(crate) fn working_bytes(casters: &Casters<'_>, root_blocks: [u32; 3]) -> u64 {
    let fullest = (0..(root_blocks[0] * root_blocks[1]) as usize)
        .map(|root_block| {
            casters.in_bin(root_block).iter().map(|&p| casters.triangles(p).len() as u64).sum::<u64>()
        })
        .max()
        .unwrap_or_default();
    // Gathering holds the surfaces at most twice. A list is at most as long as its parent's, and most are far
    // shorter.
    let any_masked = casters.scene.materials.iter().any(|m| m.alpha != AlphaMode::Opaque);
    let mask = if any_masked { size_of::<LazyMask>() + size_of::<TriangleMask>() } else { 0 };
    fullest * ((2 * size_of::<BlockSurface>() + size_of::<SnappedBox>() + mask) as u64 + 48)
}

/// Builds root block `root_block` of `root_blocks` into `sink`.
///
/// # Errors
/// Returns [`Error::Interrupted`] soon after `cancel` is set.
#[inline(never)] // Counted by `cargo xtask count`.
pub(crate) fn build_root<S: BlockSink>(
    root_blocks: &RootBlocks<'_>,
    root_block: usize,
    sink: &S,
    buffers: &mut DescentBuffers,
    cancel: &AtomicBool,
) -> Result<S::Block> {
    let rect = root_blocks.rect(root_block);
    let block = Block { level: root_blocks.root_level, x: rect.x, y: rect.y };
    let [reach, contact_reach] =
        [root_blocks.rules.reach_texels(), root_blocks.rules.contact_reach_texels()].map(reach_outside);
    let far = block.snapped(contact_reach);
    let surfaces = gather(&root_blocks.casters, root_block, &far, &root_blocks.grid, &root_blocks.rules);
    let any_masked = surfaces.iter().any(|s| s.surface.masked);
    let masks = vec![LazyMask::new(); if any_masked { surfaces.len() } else { 0 }];
    let descent = Descent {
        boxes: surfaces.iter().map(|s| SnappedBox::of(&s.surface.shape)).collect(),
        setting: Setting {
            scene: root_blocks.casters.scene,
            grid: &root_blocks.grid,
            rules: &root_blocks.rules,
            surfaces: &surfaces,
            opacity: &root_blocks.casters.clusters.opacity,
            masks: &masks,
            arch: pulp::Arch::new(),
        },
        reach,
        contact_reach,
        limit: root_blocks.limit,
        sink,
        cancel,
    };
    buffers.lists.clear();
    buffers.beside.clear();
    let rect = block.snapped(reach);
    for (s, surface) in surfaces.iter().enumerate() {
        if rect.touches(&surface.surface.shape) {
            buffers.lists.push(s as u32);
        } else if surface.receiver.is_some() {
            buffers.beside.push(s as u32);
        }
    }
    descent.build(block, [0, 0], FixedDepth::MAX, buffers)
}

/// Returns how far outside a block a surface may matter to its columns, 1/256 texel, from how far it may be
/// from their centres, texels.
fn reach_outside(texels: f64) -> i64 {
    // A centre is half a texel inside the border. Snapping moves corners.
    ((texels - 0.5) * SUBTEXEL as f64).ceil() as i64 + 2
}

struct Descent<'a, S> {
    setting: Setting<'a>,
    /// The box of each surface, stored separately so that skipping a surface beside a block takes one memory
    /// read.
    boxes: Vec<SnappedBox>,
    /// How far outside a block a surface may matter, and how far its filters may read, 1/256 texel.
    reach: i64,
    contact_reach: i64,
    limit: SwitchLimit,
    sink: &'a S,
    cancel: &'a AtomicBool,
}

impl<S: BlockSink> Descent<'_, S> {
    /// Builds a block whose surfaces are `buffers.lists[from..]`; receivers farther away are
    /// `buffers.beside[from_beside..]`. `known_behind` is the nearest depth at which removed surfaces, which
    /// are behind all resolved depths, are sampled. Recursion depth: the number of levels.
    fn build(
        &self,
        block: Block,
        [from, from_beside]: [usize; 2],
        known_behind: FixedDepth,
        buffers: &mut DescentBuffers,
    ) -> Result<S::Block> {
        let Setting { grid, rules, surfaces, .. } = self.setting;
        let [width, height, depth] = grid.size;
        if block.x >= width || block.y >= height {
            return Ok(self.sink.uniform(block.level, [0, BESIDE_GRID]));
        }
        if buffers.lists.len() == from {
            return Ok(self.sink.uniform(block.level, [depth, FREE_TO_END]));
        }
        if self.cancel.load(Ordering::Relaxed) {
            return Err(Error::Interrupted);
        }
        let (list, beside) = (&buffers.lists[from..], &buffers.beside[from_beside..]);
        let found = classify(&block, surfaces, list, beside, known_behind, rules, &mut buffers.classify);
        let resolved = match found {
            Classification::Resolved(interval) => {
                return Ok(self.sink.uniform(block.level, self.limit.interval(interval)));
            }
            // Keep all surfaces: the requirements of static receivers depend on all of them.
            Classification::Unresolved { .. } if rules.receivers == Receivers::Static => FixedDepth::MAX,
            Classification::Unresolved { resolved } => resolved,
        };
        let known_behind = buffers.forget_behind(&block, from, resolved, &self.setting).min(known_behind);
        if block.level == LEAF_LEVEL {
            return Ok(self.leaf(block, [from, from_beside], known_behind, buffers));
        }
        let (to, to_beside) = (buffers.lists.len(), buffers.beside.len());
        let mut build = |q| {
            let quarter = block.quarter(q);
            let (rect, far) = (quarter.snapped(self.reach), quarter.snapped(self.contact_reach));
            for place in from..to {
                let s = buffers.lists[place];
                let (surface, surface_box) = (&surfaces[s as usize], &self.boxes[s as usize]);
                if !far.meets(surface_box) {
                    continue;
                }
                let shape = &surface.surface.shape;
                if rect.meets(surface_box) && rect.touches_within_box(shape) {
                    buffers.lists.push(s);
                } else if surface.receiver.is_some() && far.touches_within_box(shape) {
                    buffers.beside.push(s);
                }
            }
            for place in from_beside..to_beside {
                let s = buffers.beside[place];
                let shape = &surfaces[s as usize].surface.shape;
                if far.meets(&self.boxes[s as usize]) && far.touches_within_box(shape) {
                    buffers.beside.push(s);
                }
            }
            let built = self.build(quarter, [to, to_beside], known_behind, buffers);
            buffers.lists.truncate(to);
            buffers.beside.truncate(to_beside);
            built
        };
        let quarters = [build(0)?, build(1)?, build(2)?, build(3)?];
        Ok(self.sink.join(block.level, quarters))
    }

    fn leaf(
        &self,
        block: Block,
        [from, from_beside]: [usize; 2],
        known_behind: FixedDepth,
        buffers: &mut DescentBuffers,
    ) -> S::Block {
        let side = BLOCK_SIDE as u32;
        let width = side.min(self.setting.grid.size[0] - block.x);
        let height = side.min(self.setting.grid.size[1] - block.y);
        buffers.drawn_texels += u64::from(width * height);
        let (list, beside) = (&buffers.lists[from..], &buffers.beside[from_beside..]);
        let mut columns = if self.setting.rules.receivers == Receivers::All {
            let row = 0xff >> (side - width);
            let inside = (0..height).fold(0_u64, |mask, y| mask | row << (8 * y));
            let near = NearSurfaces { list, ranges: &buffers.classify.ranges, beside };
            leaf_columns(&block, inside, near, known_behind, self.setting, &mut buffers.leaf)
        } else {
            let rect = TexelRect { x: block.x, y: block.y, width, height };
            let near = Near { descent: self, list, beside };
            capture(&near, self.setting.rules, rect, &mut buffers.capture, &mut buffers.columns);
            BlockColumns::padded(&buffers.columns)
        };
        self.limit.cut(&columns.e, &mut columns.x);
        self.sink.leaf(&columns)
    }
}

/// The surfaces near one block.
struct Near<'a, S> {
    descent: &'a Descent<'a, S>,
    list: &'a [u32],
    beside: &'a [u32],
}

impl<S> Surfaces for Near<'_, S> {
    fn scene(&self) -> &Scene {
        self.descent.setting.scene
    }

    fn grid(&self) -> &LightGrid {
        self.descent.setting.grid
    }

    fn for_each(&self, mut visit: impl FnMut(&Surface)) {
        for &s in self.list.iter().chain(self.beside) {
            visit(&self.descent.setting.surfaces[s as usize].surface);
        }
    }
}
