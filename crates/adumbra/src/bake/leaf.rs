//! The columns of one 8 × 8 block, from the surfaces near it: what `capture.rs` finds for a tile, but a block at a time, in bit
//! masks, and asking for receivers only where an answer depends on them.
//!
//! A column whose first surface bounds a solid needs to know whether anything lies behind the solid, not where; a surface
//! sampled there says so at once. What is left to ask is about open first surfaces.

use super::block::{Block, BlockSurface};
use super::columns::{self, ColumnRules, FOOTPRINT_HALF, FirstSurface, ReceiverKind};
use super::masked::{self, MaskedHit, TriangleMask};
use super::project::{FixedDepth, Projected};
use super::sink::{BLOCK_SIDE, BlockColumns};
use super::surface::Surface;
use crate::light::LightGrid;
use crate::scene::Scene;

const TEXELS: usize = BLOCK_SIDE * BLOCK_SIDE;
/// The place of no surface.
const NOBODY: u32 = u32::MAX;
/// A sampled depth that is behind a threshold by more than this is behind it however it is computed, 1/256 voxel.
const CERTAINLY_BEHIND: FixedDepth = 2;

/// A surface near the block, by its depth range there.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Near {
    low: FixedDepth,
    high: FixedDepth,
    surface: u32,
}

/// Buffers that one worker reuses from block to block.
#[derive(Default)]
pub(super) struct LeafBuffers {
    /// Nearest first.
    order: Vec<Near>,
    /// Texel, and key of a solid's crossing.
    crossings: Vec<(u8, u32)>,
    sorted: Vec<u32>,
    masked: Vec<MaskedHit>,
}

/// Where leaves lie, and what decides them.
#[derive(Clone, Copy)]
pub(super) struct Setting<'a> {
    pub(super) scene: &'a Scene,
    pub(super) grid: &'a LightGrid,
    pub(super) rules: &'a ColumnRules,
    pub(super) surfaces: &'a [BlockSurface],
}

/// The columns while they are found.
struct Leaf<'b> {
    setting: Setting<'b>,
    block: &'b Block,
    /// Texels of the grid.
    inside: u64,
    first: [FirstSurface; TEXELS],
    /// Place in the list of the surface that `first` is of.
    owner: [u32; TEXELS],
    /// Solids entered so far, less those left.
    entered: [i32; TEXELS],
    /// The deepest sample of a column.
    deepest: [FixedDepth; TEXELS],
    base: [FixedDepth; TEXELS],
    next: [FixedDepth; TEXELS],
    buffers: &'b mut LeafBuffers,
}

/// Columns of `block`, which has level 3, as [`super::columns::ColumnRules::column`] of what lies over them; `inside` are the
/// texels of the grid. Something at `known_behind` or deeper lies behind every first surface and every solid that is met
/// first; [`FixedDepth::MAX`] where nothing is known. For [`Receivers::All`](crate::settings::Receivers::All).
#[inline(never)] // Counted by `cargo xtask count`.
pub(super) fn leaf_columns(
    block: &Block,
    inside: u64,
    list: &[u32],
    known_behind: FixedDepth,
    setting: Setting<'_>,
    buffers: &mut LeafBuffers,
) -> BlockColumns {
    buffers.crossings.clear();
    buffers.masked.clear();
    buffers.order(block, list, setting.surfaces);
    let order = std::mem::take(&mut buffers.order);
    let mut leaf = Leaf {
        setting,
        block,
        inside,
        first: [FirstSurface::NONE; TEXELS],
        owner: [NOBODY; TEXELS],
        entered: [0; TEXELS],
        deepest: [FixedDepth::MIN; TEXELS],
        base: [0; TEXELS],
        next: [FixedDepth::MAX; TEXELS],
        buffers,
    };
    leaf.sample_all(&order);
    leaf.add_masked();
    leaf.resolve_solids();
    leaf.ask_all(&order, known_behind);
    let mut columns = BlockColumns::free();
    for texel in bits(inside) {
        [columns.e[texel], columns.x[texel]] =
            setting.rules.column(leaf.first[texel], leaf.base[texel], leaf.next[texel]);
    }
    buffers.order = order;
    columns
}

impl LeafBuffers {
    fn order(&mut self, block: &Block, list: &[u32], surfaces: &[BlockSurface]) {
        self.order.clear();
        self.order.extend(list.iter().map(|&surface| {
            let [low, high] = surfaces[surface as usize].surface.shape.fixed_range_over(block);
            Near { low, high, surface }
        }));
        self.order.sort_unstable();
    }
}

impl Leaf<'_> {
    /// Samples from the light on, and stops asking columns that are settled: no surface that has been met reaches past the next
    /// one, and every solid that was entered has been left.
    fn sample_all(&mut self, order: &[Near]) {
        let (mut reached, mut settled) = (FixedDepth::MIN, 0);
        for near in order {
            let surface = &self.setting.surfaces[near.surface as usize].surface;
            if !surface.casts {
                continue;
            }
            if near.low > reached {
                settled = bits(self.inside & !settled)
                    .filter(|&texel| !self.first[texel].is_none() && self.entered[texel] == 0)
                    .fold(settled, |mask, texel| mask | 1 << texel);
            }
            reached = reached.max(near.high);
            self.sample(near, surface, settled);
        }
    }

    fn sample(&mut self, near: &Near, surface: &Surface, settled: u64) {
        let (block, Setting { scene, grid, rules, .. }) = (self.block, self.setting);
        let shape = &surface.shape;
        let Some(plane) = shape.plane else { return };
        let covered = shape.coverage(block.x, block.y) & self.inside;
        if !surface.masked {
            for texel in bits(covered & settled) {
                self.deepest[texel] = self.deepest[texel].max(near.low);
            }
        }
        let covered = covered & !settled;
        if covered == 0 {
            return;
        }
        let info = rules.surface_info(shape.slope, surface.solid);
        if surface.masked {
            let Some(mask) = TriangleMask::new(scene, grid, surface) else { return };
            for texel in bits(covered) {
                let [x, y] = center(block, texel);
                let places = mask.coverage(scene, x, y);
                if places != 0 {
                    let depth = shape.depth_at(&plane, x, y);
                    self.buffers.masked.push(MaskedHit::new(texel, depth, info, places));
                }
            }
            return;
        }
        let exit_bit = u32::from(!shape.faces_sun);
        for texel in bits(covered) {
            let [x, y] = center(block, texel);
            let depth = shape.depth_at(&plane, x, y);
            let first = FirstSurface::new(depth, info);
            if first < self.first[texel] {
                self.first[texel] = first;
                self.owner[texel] = near.surface;
            }
            self.deepest[texel] = self.deepest[texel].max(depth);
            if surface.solid {
                self.entered[texel] += if shape.faces_sun { 1 } else { -1 };
                self.buffers.crossings.push((texel as u8, columns::crossing_key(depth, exit_bit)));
            }
        }
    }

    /// Surfaces with holes, where they cover enough before anything else does.
    fn add_masked(&mut self) {
        if self.buffers.masked.is_empty() {
            return;
        }
        let before = self.first;
        masked::add_first_surfaces(&mut self.buffers.masked, &mut self.first);
        for (texel, owner) in self.owner.iter_mut().enumerate() {
            if self.first[texel] != before[texel] {
                *owner = NOBODY;
            }
        }
    }

    /// Leaves the depth behind which other receivers matter in `base`: the end of the solid that is met first, or the first
    /// surface itself.
    fn resolve_solids(&mut self) {
        self.base = self.first.map(FirstSurface::depth);
        let mut ends = [0_u32; TEXELS];
        let LeafBuffers { crossings, sorted, .. } = &mut *self.buffers;
        for (texel, _) in crossings.iter() {
            ends[usize::from(*texel)] += 1;
        }
        let mut sum = 0;
        for end in &mut ends {
            sum += std::mem::replace(end, sum);
        }
        sorted.clear();
        sorted.resize(crossings.len(), 0);
        for (texel, key) in crossings.iter() {
            let end = &mut ends[usize::from(*texel)];
            sorted[*end as usize] = *key;
            *end += 1;
        }
        let mut start = 0;
        for (texel, &end) in ends.iter().enumerate() {
            let keys = &mut sorted[start..end as usize];
            if !keys.is_empty() && self.first[texel].is_solid() {
                keys.sort_unstable();
                match columns::solid_end(keys) {
                    Some(exit) => self.base[texel] = exit,
                    None => self.first[texel].set_open(),
                }
            }
            start = end as usize;
        }
    }

    /// Finds what lies behind the bases of all columns that must know. Something at `known_behind` or deeper lies behind them
    /// all.
    fn ask_all(&mut self, order: &[Near], known_behind: FixedDepth) {
        let rules = self.setting.rules;
        let (mut asking, mut threshold) = (0, FixedDepth::MAX);
        for texel in bits(self.inside) {
            let first = self.first[texel];
            if first.is_none() {
                continue;
            }
            let behind = self.base[texel].saturating_add(first.bias());
            self.next[texel] = known_behind;
            if first.is_solid() && self.deepest[texel] > behind.saturating_add(CERTAINLY_BEHIND) {
                self.next[texel] = known_behind.min(self.deepest[texel]);
            }
            if !first.is_solid() || self.next[texel] == FixedDepth::MAX {
                asking |= 1 << texel;
                threshold = threshold.min(behind);
            }
        }
        if asking == 0 {
            return;
        }
        for near in order.iter().filter(|near| near.high > threshold) {
            // Nearest first: what no longer matters to a column will not matter again.
            asking = bits(asking)
                .filter(|&texel| near.low < self.matters_before(texel))
                .fold(0, |mask, texel| mask | 1 << texel);
            if asking == 0 {
                return;
            }
            let shape = &self.setting.surfaces[near.surface as usize].surface.shape;
            let mut wanted = asking;
            if shape.rise(FOOTPRINT_HALF) + f64::from(CERTAINLY_BEHIND)
                <= f64::from(rules.bias_fixed(shape.slope))
            {
                // Within a footprint it does not lie behind itself.
                let own = |&texel: &usize| self.owner[texel] == near.surface && !self.is_behind_solid(texel);
                wanted = bits(asking).filter(|t| !own(t)).fold(0, |mask, texel| mask | 1 << texel);
            }
            self.ask(wanted, shape);
        }
    }

    /// Receivers at this depth or behind it change nothing about a column: a nearer one is known, or one that leaves an open surface
    /// all its thickness, or any behind a solid.
    fn matters_before(&self, texel: usize) -> FixedDepth {
        let (first, next) = (self.first[texel], self.next[texel]);
        if next == FixedDepth::MAX {
            next
        } else if first.is_solid() {
            FixedDepth::MIN
        } else {
            next.min(self.setting.rules.full_thickness_from(first))
        }
    }

    /// The base lies behind the first surface.
    fn is_behind_solid(&self, texel: usize) -> bool {
        self.base[texel] > self.first[texel].depth()
    }

    /// `shape` as a receiver, for the texels of `wanted`.
    fn ask(&mut self, wanted: u64, shape: &Projected) {
        let (block, rules) = (self.block, self.setting.rules);
        let half = FOOTPRINT_HALF;
        for row in 0..BLOCK_SIDE {
            let wanted = wanted >> (row * BLOCK_SIDE) & 0xff;
            if wanted == 0 {
                continue;
            }
            let y = f64::from(block.y) + row as f64 + 0.5;
            let Some(band) = shape.band(y, half) else { continue };
            for column in bits(wanted) {
                let x = f64::from(block.x) + column as f64 + 0.5;
                if x < band.x[0] - half || x > band.x[1] + half {
                    continue;
                }
                let texel = row * BLOCK_SIDE + column;
                let kind = ReceiverKind::Everywhere;
                let (range, z_plane) = shape.footprint_range(&band, x, y, half);
                if let Some(asked) = rules.asked_depths(kind, shape.slope, range, z_plane) {
                    let next = rules.receiver_behind(kind, self.base[texel], self.first[texel], asked);
                    self.next[texel] = self.next[texel].min(next);
                }
            }
        }
    }
}

fn center(block: &Block, texel: usize) -> [f64; 2] {
    let (column, row) = ((texel % BLOCK_SIDE) as u32, (texel / BLOCK_SIDE) as u32);
    [block.x + column, block.y + row].map(|c| f64::from(c) + 0.5)
}

/// The numbers of the bits that are set.
pub(super) fn bits(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (mask != 0).then(|| {
            let bit = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            bit
        })
    })
}
