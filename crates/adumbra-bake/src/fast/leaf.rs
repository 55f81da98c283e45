//! The columns of one 8 × 8 block, from the surfaces near it. The result is that of `capture.rs` for a tile, but
//! computed a block at a time in bit masks, and receivers are evaluated only if an answer depends on them.
//!
//! A column needs to know whether a receiver is behind its base, and whether one samples it nearer than its exit. A
//! surface that is sampled far behind a solid settles the first question at once. The remaining work concerns open
//! first surfaces and thin gaps.

use crate::columns::masked;
use crate::columns::masked::{MaskedHit, TriangleMask};
use crate::columns::rules as columns;
use crate::columns::rules::{ColumnRules, FREE_TO_END, FirstSurface, ReceiverKind, SeamHit};
use crate::columns::{BLOCK_SIDE, BlockColumns};
use crate::fast::block::{Block, BlockSurface, SurfaceRange};
use crate::texel_mask::{texels_of, texels_where};
use crate::triangles::project::{FixedDepth, SEAM_MARGIN, SUBTEXEL};
use crate::triangles::surface::Surface;
use adumbra::grid::LightGrid;
use adumbra_scene::Scene;

const TEXELS: usize = BLOCK_SIDE * BLOCK_SIDE;
/// Owner of a texel whose first surface is not a single surface of the list.
const NOBODY: u32 = u32::MAX;
/// A receiver that samples a column at least this far behind its exit does not change the column: rounding of the exit,
/// 1/256 voxel.
const BEHIND_EXIT: FixedDepth = SUBTEXEL as FixedDepth / 2 + 1;

/// The surfaces near the block.
#[derive(Clone, Copy)]
pub(crate) struct NearSurfaces<'a> {
    /// Indices into [`Setting::surfaces`].
    pub(crate) list: &'a [u32],
    /// Depth bounds over the block of each surface in the list.
    pub(crate) ranges: &'a [SurfaceRange],
}

/// A surface near the block, with its depth range there.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Near {
    low: FixedDepth,
    high: FixedDepth,
    surface: u32,
    /// Index into the list.
    place: u32,
}

/// Buffers that a worker reuses from block to block.
#[derive(Default)]
pub(crate) struct LeafBuffers {
    /// Nearest first.
    order: Vec<Near>,
    /// Texel, and the key of a solid's crossing.
    crossings: Vec<(u8, u32)>,
    sorted: Vec<u32>,
    masked: Vec<MaskedHit>,
    seams: Vec<SeamHit>,
}

/// The inputs shared by all leaves of a root block.
#[derive(Clone, Copy)]
pub(crate) struct Setting<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) grid: &'a LightGrid,
    pub(crate) rules: &'a ColumnRules,
    pub(crate) surfaces: &'a [BlockSurface],
}

/// The columns of a leaf while they are computed.
struct Leaf<'b> {
    setting: Setting<'b>,
    block: &'b Block,
    ranges: &'b [SurfaceRange],
    /// Texels of the grid.
    inside: u64,
    first: [FirstSurface; TEXELS],
    /// Index into [`Setting::surfaces`] of the surface that provides `first`.
    owner: [u32; TEXELS],
    /// Number of solids entered so far, minus those left.
    entered: [i32; TEXELS],
    /// Some receiver is known to sample the column at this depth or deeper.
    deepest: [FixedDepth; TEXELS],
    base: [FixedDepth; TEXELS],
    next: [FixedDepth; TEXELS],
    /// A receiver that samples the column at this depth or deeper cannot change it: either a nearer one is known, or
    /// the column is known to have a receiver and is in shadow by then anyway.
    matters_before: [FixedDepth; TEXELS],
    /// Texel centres, by column and by row.
    centers: [[f64; BLOCK_SIDE]; 2],
    buffers: &'b mut LeafBuffers,
}

/// Computes the columns of `block`, which has level 3, by [`crate::columns::rules::ColumnRules::column`]. `inside` is
/// the set of texels in the grid. Something is sampled at `known_behind` or deeper, behind every first surface and
/// every solid that is hit first; [`FixedDepth::MAX`] if nothing is known. For
/// [`Receivers::All`](adumbra::Receivers::All).
#[inline(never)] // Counted by `cargo xtask count`.
pub(crate) fn leaf_columns(
    block: &Block,
    inside: u64,
    near: NearSurfaces<'_>,
    known_behind: FixedDepth,
    setting: Setting<'_>,
    buffers: &mut LeafBuffers,
) -> BlockColumns {
    buffers.crossings.clear();
    buffers.masked.clear();
    buffers.seams.clear();
    buffers.order(near);
    let order = std::mem::take(&mut buffers.order);
    let mut leaf = Leaf {
        setting,
        block,
        ranges: near.ranges,
        inside,
        first: [FirstSurface::NONE; TEXELS],
        owner: [NOBODY; TEXELS],
        entered: [0; TEXELS],
        deepest: [FixedDepth::MIN; TEXELS],
        base: [0; TEXELS],
        next: [FixedDepth::MAX; TEXELS],
        matters_before: [FixedDepth::MIN; TEXELS],
        centers: [block.x, block.y].map(|from| std::array::from_fn(|i| f64::from(from) + i as f64 + 0.5)),
        buffers,
    };
    leaf.sample_all(&order);
    leaf.add_seams(&order);
    leaf.add_masked();
    leaf.resolve_solids();
    leaf.ask_all(&order, known_behind);
    let mut columns = BlockColumns::free();
    for texel in texels_of(inside) {
        [columns.e[texel], columns.x[texel]] =
            setting.rules.column(leaf.first[texel], leaf.base[texel], leaf.next[texel]);
    }
    buffers.order = order;
    columns
}

impl LeafBuffers {
    fn order(&mut self, near: NearSurfaces<'_>) {
        self.order.clear();
        let surfaces = near.list.iter().zip(near.ranges).zip(0..);
        self.order.extend(surfaces.map(|((&surface, range), place)| Near {
            low: range.low,
            high: range.high,
            surface,
            place,
        }));
        self.order.sort_unstable();
    }
}

impl Leaf<'_> {
    /// Samples surfaces from the light on, and skips columns that are resolved: no surface visited so far extends past
    /// the next one, and every solid that was entered has been left.
    fn sample_all(&mut self, order: &[Near]) {
        let (mut reached, mut resolved) = (FixedDepth::MIN, 0);
        for near in order {
            let surface = &self.setting.surfaces[near.surface as usize].surface;
            if !surface.casts {
                continue;
            }
            if near.low > reached {
                resolved = texels_of(self.inside & !resolved)
                    .filter(|&texel| !self.first[texel].is_none() && self.entered[texel] == 0)
                    .fold(resolved, |mask, texel| mask | 1 << texel);
            }
            reached = reached.max(near.high);
            self.sample(near, surface, resolved);
        }
    }

    fn sample(&mut self, near: &Near, surface: &Surface, resolved: u64) {
        let (block, Setting { scene, grid, rules, .. }) = (self.block, self.setting);
        let shape = &surface.shape;
        let Some(plane) = shape.plane else { return };
        let [exact, grown] = if surface.solid && !shape.faces_sun {
            [shape.coverage(block.x, block.y, [0])[0]; 2]
        } else {
            shape.coverage(block.x, block.y, [0, SEAM_MARGIN])
        };
        let wanted = self.inside & !resolved;
        let covered = if surface.solid { exact } else { grown } & wanted;
        let seam = if surface.solid { grown & !exact & wanted } else { 0 };
        if !surface.masked
            && exact & self.inside != 0
            && let Some(range) = &self.ranges[near.place as usize].sampled
        {
            for texel in texels_of(exact & self.inside) {
                self.deepest[texel] = self.deepest[texel].max(range.lifted_low);
            }
        }
        if covered | seam == 0 {
            return;
        }
        let info = rules.surface_info(shape.slope, surface.solid);
        if surface.masked {
            let Some(mask) = TriangleMask::new(scene, grid, surface) else { return };
            for texel in texels_of(covered) {
                let [x, y] = self.center(texel);
                let places = mask.coverage(scene, x, y);
                if places != 0 {
                    let depth = shape.depth_at(&plane, x, y);
                    self.buffers.masked.push(MaskedHit::new(texel, depth, info, places));
                }
            }
            return;
        }
        for texel in texels_of(seam) {
            let [x, y] = self.center(texel);
            let depth = shape.depth_at(&plane, x, y);
            self.buffers.seams.push(SeamHit::new(texel, depth, info, surface));
        }
        let exit_bit = u32::from(!shape.faces_sun);
        for texel in texels_of(covered) {
            let [x, y] = self.center(texel);
            let depth = shape.depth_at(&plane, x, y);
            let first = FirstSurface::new(depth, info);
            if first < self.first[texel] {
                self.first[texel] = first;
                self.owner[texel] = near.surface;
            }
            if surface.solid {
                self.entered[texel] += if shape.faces_sun { 1 } else { -1 };
                self.buffers.crossings.push((texel as u8, columns::crossing_key(depth, exit_bit)));
            }
        }
    }

    fn center(&self, texel: usize) -> [f64; 2] {
        [self.centers[0][texel % BLOCK_SIDE], self.centers[1][texel / BLOCK_SIDE]]
    }

    fn add_seams(&mut self, order: &[Near]) {
        let Self { first, owner, buffers, block, .. } = self;
        if !columns::keep_meeting_seams(&mut buffers.seams) {
            return;
        }
        for near in order {
            let surface = &self.setting.surfaces[near.surface as usize].surface;
            columns::drop_covered_seams(&mut buffers.seams, surface, |texel| {
                let (x, y) = ((texel % BLOCK_SIDE) as u32, (texel / BLOCK_SIDE) as u32);
                surface.shape.covers(i64::from(block.x + x), i64::from(block.y + y))
            });
        }
        columns::close_seams(&buffers.seams, |texel, surface| {
            if surface < first[texel] {
                (first[texel], owner[texel]) = (surface, NOBODY);
            }
        });
    }

    /// Adds masked surfaces where they cover enough of a texel and are nearest.
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

    /// Writes to `base` the depth behind which other receivers matter: the end of the solid that is hit first, or the
    /// first surface itself.
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

    /// Finds, for each column with a first surface, the nearest depth at which a receiver behind its base samples it.
    /// Something behind all bases is sampled at `known_behind` or deeper.
    fn ask_all(&mut self, order: &[Near], known_behind: FixedDepth) {
        let (mut asking, mut base_low, mut first_low) = (0, FixedDepth::MAX, FixedDepth::MAX);
        let met = texels_where(|texel| !self.first[texel].is_none());
        for texel in texels_of(self.inside & met) {
            let (first, base) = (self.first[texel], self.base[texel]);
            self.next[texel] = known_behind;
            let shadowed_from = self.shadowed_from(texel);
            let farthest = shadowed_from.max(base.saturating_add(SUBTEXEL as FixedDepth));
            if self.deepest[texel] > farthest {
                self.next[texel] = known_behind.min(self.deepest[texel]);
            }
            let any_counts = self.next[texel] == FixedDepth::MAX && self.setting.rules.assume_ground;
            self.matters_before[texel] =
                if any_counts { FixedDepth::MAX } else { shadowed_from.min(self.next[texel]) };
            asking |= 1 << texel;
            base_low = base_low.min(base);
            first_low = first_low.min(first.depth());
        }
        let half = self.setting.rules.footprint_half_texels(ReceiverKind::Footprint);
        // Snapping may have moved the corners.
        let reach = (half * SUBTEXEL as f64).ceil() as i64 + 2;
        let mut any_matters_before = self.any_matters_before(asking);
        for near in order {
            let Some(range) = &self.ranges[near.place as usize].sampled else { continue };
            if range.deepest <= base_low
                || range.lifted_high <= first_low
                || range.lifted_low >= any_matters_before
            {
                continue;
            }
            // The first surface is not behind itself.
            let surface = &self.setting.surfaces[near.surface as usize];
            let within_reach = surface.surface.shape.centers_within_box(self.block.x, self.block.y, reach);
            let wanted = texels_of(asking & within_reach)
                .filter(|&t| self.owner[t] != near.surface)
                .filter(|&t| range.lifted_low < self.matters_before[t] && range.deepest > self.base[t])
                .fold(0, |mask, texel| mask | 1 << texel);
            if wanted != 0 {
                self.ask(wanted, surface);
                any_matters_before = self.any_matters_before(asking);
            }
        }
    }

    /// Returns the largest of [`Self::matters_before`] over these texels.
    fn any_matters_before(&self, asking: u64) -> FixedDepth {
        texels_of(asking).map(|texel| self.matters_before[texel]).max().unwrap_or(FixedDepth::MIN)
    }

    /// Returns the depth from which on the column is in shadow, whatever is behind it; [`FixedDepth::MAX`] if its exit
    /// is beyond the grid.
    fn shadowed_from(&self, texel: usize) -> FixedDepth {
        let rules = self.setting.rules;
        let exit = rules.exit(self.first[texel], self.base[texel]);
        if rules.latest_switch(exit) == FREE_TO_END {
            FixedDepth::MAX
        } else {
            exit.saturating_add(BEHIND_EXIT)
        }
    }

    /// Evaluates `surface` as a receiver for the texels in `wanted`.
    fn ask(&mut self, wanted: u64, BlockSurface { surface, receiver, .. }: &BlockSurface) {
        let (block, rules) = (self.block, self.setting.rules);
        let Some(receiver) = receiver else { return };
        let half = rules.footprint_half_texels(ReceiverKind::Footprint);
        for row in 0..BLOCK_SIDE {
            let wanted = wanted >> (row * BLOCK_SIDE) & 0xff;
            if wanted == 0 {
                continue;
            }
            let y = self.centers[1][row];
            let Some([low, high]) = surface.shape.x_range_in_band(y, half) else { continue };
            for column in texels_of(wanted) {
                let x = self.centers[0][column];
                if x < low - half || x > high + half {
                    continue;
                }
                let texel = row * BLOCK_SIDE + column;
                let at = [block.x + column as u32, block.y + row as u32].map(i64::from);
                let (base, first) = (self.base[texel], self.first[texel]);
                let triangle = (&surface.shape, receiver);
                let next = rules.receiver_behind(ReceiverKind::Footprint, triangle, at, base, first);
                if next < self.next[texel] {
                    self.next[texel] = next;
                    self.matters_before[texel] = next.min(self.shadowed_from(texel));
                }
            }
        }
    }
}
