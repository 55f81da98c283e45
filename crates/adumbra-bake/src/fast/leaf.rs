//! The columns of one 8 × 8 block, from the surfaces near it. The result is that of `capture.rs` for a tile, but
//! computed a block at a time in bit masks, and receivers are evaluated only if an answer depends on them.
//!
//! A column needs to know whether a receiver is behind its base, and whether one samples it nearer than its exit. A
//! surface that is sampled far behind a solid settles the first question at once. The remaining work concerns open
//! first surfaces and thin gaps.

use crate::columns::masked;
use crate::columns::masked::{MaskedHit, TriangleMask};
use crate::columns::rules as columns;
use crate::columns::rules::{CONTACT_RINGS, ColumnRules, FREE_TO_END, FirstSurface, ReceiverKind, SeamHit};
use crate::columns::{BLOCK_SIDE, BlockColumns};
use crate::fast::block::{Block, BlockSurface, SurfaceRange};
use crate::texel_mask::{texels_of, texels_where};
use crate::triangles::opacity::OpacityPyramid;
use crate::triangles::project::{FixedDepth, SEAM_MARGIN, SUBTEXEL, depths_within};
use crate::triangles::surface::Surface;
use adumbra::grid::LightGrid;
use adumbra_scene::Scene;

const TEXELS: usize = BLOCK_SIDE * BLOCK_SIDE;
/// One value per texel, by row and column. Loops over rows of eight are what compilers vectorize.
type Texels<T> = [[T; BLOCK_SIDE]; BLOCK_SIDE];
/// More than the rounding of a plane's depth, voxels.
const ROUNDING: f64 = 1.0 / SUBTEXEL as f64;
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
    /// Indices into [`Setting::surfaces`] of receivers farther away, whose filters may read the block's columns.
    pub(crate) beside: &'a [u32],
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
    /// Nearest first, by the least depth.
    crossings: Vec<Crossings>,
    masked: Vec<MaskedHit>,
    seams: Vec<SeamHit>,
}

/// Where the columns cross one surface of a solid.
struct Crossings {
    covered: u64,
    leaves: bool,
    /// Bounds of the depths.
    low: FixedDepth,
    high: FixedDepth,
    depths: Texels<FixedDepth>,
}

/// The inputs shared by all leaves of a root block.
#[derive(Clone, Copy)]
pub(crate) struct Setting<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) grid: &'a LightGrid,
    pub(crate) rules: &'a ColumnRules,
    pub(crate) surfaces: &'a [BlockSurface],
    /// For each material: where it is opaque.
    pub(crate) opacity: &'a [Option<OpacityPyramid>],
    /// The processor's vectors.
    pub(crate) arch: pulp::Arch,
}

/// The columns of a leaf while they are computed.
struct Leaf<'b> {
    setting: Setting<'b>,
    block: &'b Block,
    ranges: &'b [SurfaceRange],
    /// Texels of the grid.
    inside: u64,
    first: Firsts,
    /// Number of solids entered so far, minus those left.
    entered: Texels<i32>,
    /// Some receiver is known to sample the column at this depth or deeper.
    deepest: Texels<FixedDepth>,
    base: Texels<FixedDepth>,
    next: Texels<FixedDepth>,
    /// The column is in shadow from this depth on, whatever is behind it.
    shadowed_from: Texels<FixedDepth>,
    /// A receiver that samples the column at this depth or deeper cannot change it: either a nearer one is known, or
    /// the column is known to have a receiver and is in shadow by then anyway.
    matters_before: Texels<FixedDepth>,
    /// Texel centres, by column and by row.
    centers: [[f64; BLOCK_SIDE]; 2],
    buffers: &'b mut LeafBuffers,
}

/// The first surfaces of a leaf's columns.
struct Firsts {
    /// Depths and infos of [`FirstSurface`].
    depth: Texels<FixedDepth>,
    info: Texels<u32>,
    /// Index into [`Setting::surfaces`] of the surface that is first.
    owner: Texels<u32>,
}

impl Firsts {
    #[inline(always)]
    fn none() -> Self {
        let none = FirstSurface::NONE;
        Self {
            depth: [[none.depth(); BLOCK_SIDE]; BLOCK_SIDE],
            info: [[none.info(); BLOCK_SIDE]; BLOCK_SIDE],
            owner: [[NOBODY; BLOCK_SIDE]; BLOCK_SIDE],
        }
    }

    #[inline(always)]
    fn get(&self, texel: usize) -> FirstSurface {
        FirstSurface::new(self.depth.as_flattened()[texel], self.info.as_flattened()[texel])
    }

    /// Makes this the first surface of a column, with no owner.
    fn set(&mut self, texel: usize, first: FirstSurface) {
        self.depth.as_flattened_mut()[texel] = first.depth();
        self.info.as_flattened_mut()[texel] = first.info();
        self.owner.as_flattened_mut()[texel] = NOBODY;
    }

    fn set_open(&mut self, texel: usize) {
        let mut first = self.get(texel);
        first.set_open();
        self.info.as_flattened_mut()[texel] = first.info();
    }

    /// Returns the columns that have one.
    #[inline(always)]
    fn met(&self) -> u64 {
        texels_where(|texel| !self.get(texel).is_none())
    }

    /// Adds a surface with these depths to the texels `covered` of a row.
    #[inline(always)]
    fn add_row(
        &mut self,
        row: usize,
        covered: &Lanes,
        depths: &[FixedDepth; BLOCK_SIDE],
        info: u32,
        owner: u32,
    ) {
        let (depth, infos, owners) = (&mut self.depth[row], &mut self.info[row], &mut self.owner[row]);
        for c in 0..BLOCK_SIDE {
            let d = depths[c];
            let is_first = (d < depth[c]) | (d == depth[c]) & (info < infos[c]);
            let is_new = is_first & (covered[c] != 0);
            depth[c] = if is_new { d } else { depth[c] };
            infos[c] = if is_new { info } else { infos[c] };
            owners[c] = if is_new { owner } else { owners[c] };
        }
    }
}

/// The texels of a set in one row: all bits of a lane, or none.
type Lanes = [i32; BLOCK_SIDE];

/// The lanes of every row of eight bits.
static LANES: [Lanes; 256] = {
    let mut lanes = [[0; BLOCK_SIDE]; 256];
    let mut i = 0;
    while i < 256 * BLOCK_SIDE {
        let (row, column) = (i / BLOCK_SIDE, i % BLOCK_SIDE);
        lanes[row][column] = -((row >> column & 1) as i32);
        i += 1;
    }
    lanes
};

/// Iterates over the rows of `mask` that have texels: number and texels of the row.
#[inline(always)]
fn rows_of(mask: u64) -> impl Iterator<Item = (usize, &'static Lanes)> {
    let rows = mask.to_le_bytes().into_iter().enumerate();
    rows.filter(|(_, texels)| *texels != 0).map(|(row, texels)| (row, &LANES[usize::from(texels)]))
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
    setting.arch.dispatch(Task { block, inside, near, known_behind, setting, buffers })
}

/// The arguments of [`leaf_columns`].
struct Task<'a> {
    block: &'a Block,
    inside: u64,
    near: NearSurfaces<'a>,
    known_behind: FixedDepth,
    setting: Setting<'a>,
    buffers: &'a mut LeafBuffers,
}

impl pulp::WithSimd for Task<'_> {
    type Output = BlockColumns;

    /// Inlined, like all loops over texels below it, into a function that is compiled for the widest vectors at hand.
    /// No result depends on them.
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> BlockColumns {
        compute(self)
    }
}

#[inline(always)]
fn compute(Task { block, inside, near, known_behind, setting, buffers }: Task<'_>) -> BlockColumns {
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
        first: Firsts::none(),
        entered: [[0; BLOCK_SIDE]; BLOCK_SIDE],
        deepest: [[FixedDepth::MIN; BLOCK_SIDE]; BLOCK_SIDE],
        base: [[0; BLOCK_SIDE]; BLOCK_SIDE],
        next: [[FixedDepth::MAX; BLOCK_SIDE]; BLOCK_SIDE],
        shadowed_from: [[FixedDepth::MIN; BLOCK_SIDE]; BLOCK_SIDE],
        matters_before: [[FixedDepth::MIN; BLOCK_SIDE]; BLOCK_SIDE],
        centers: [centers(block.x), centers(block.y)],
        buffers,
    };
    leaf.sample_all(&order);
    leaf.add_seams(&order);
    leaf.add_masked();
    leaf.resolve_solids();
    leaf.ask_all(&order, known_behind);
    let mut columns = leaf.columns();
    leaf.bound(near, &mut columns);
    buffers.order = order;
    columns
}

/// Returns the centres of eight texels from `first` on.
#[inline(always)]
fn centers(first: u32) -> [f64; BLOCK_SIDE] {
    let mut centers = [0.0; BLOCK_SIDE];
    for (i, center) in centers.iter_mut().enumerate() {
        *center = f64::from(first) + i as f64 + 0.5;
    }
    centers
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
    #[inline(always)]
    fn sample_all(&mut self, order: &[Near]) {
        let (mut reached, mut resolved) = (FixedDepth::MIN, 0);
        for near in order {
            let surface = &self.setting.surfaces[near.surface as usize].surface;
            if !surface.casts {
                continue;
            }
            if near.low > reached {
                let left = texels_where(|texel| self.entered.as_flattened()[texel] == 0);
                resolved = self.first.met() & left;
            }
            reached = reached.max(near.high);
            self.sample(near, surface, resolved);
        }
    }

    #[inline(always)]
    fn sample(&mut self, near: &Near, surface: &Surface, resolved: u64) {
        let (block, Setting { scene, grid, rules, opacity, .. }) = (self.block, self.setting);
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
            for (row, texels) in rows_of(exact & self.inside) {
                for (c, deepest) in self.deepest[row].iter_mut().enumerate() {
                    let low = if texels[c] != 0 { range.lifted_low } else { FixedDepth::MIN };
                    *deepest = low.max(*deepest);
                }
            }
        }
        if covered | seam == 0 {
            return;
        }
        let mask = if surface.masked {
            let Some(mask) = TriangleMask::new(scene, grid, surface) else { return };
            let middle = [block.x, block.y].map(|c| f64::from(c) + BLOCK_SIDE as f64 / 2.0);
            let opacity = mask.opacity_within(opacity, middle, BLOCK_SIDE as f64 / 2.0);
            if opacity == Some(false) {
                return;
            }
            Some((mask, opacity))
        } else {
            None
        };
        let mut depths = [[0; BLOCK_SIDE]; BLOCK_SIDE];
        let range = shape.depth_range();
        for (row, _) in rows_of(covered | seam) {
            depths[row] = depths_within(range, plane.along(&self.centers[0], self.centers[1][row]));
        }
        let depth = |texel: usize| depths.as_flattened()[texel];
        let info = rules.surface_info(shape.slope, surface.solid);
        if let Some((mask, opacity_here)) = mask {
            for texel in texels_of(covered) {
                let center = self.center(texel);
                let places = match opacity_here.or_else(|| mask.opacity_within(opacity, center, 0.5)) {
                    Some(true) => u16::MAX,
                    Some(false) => 0,
                    None => mask.coverage(scene, center),
                };
                if places != 0 {
                    self.buffers.masked.push(MaskedHit::new(texel, depth(texel), info, places));
                }
            }
            return;
        }
        let seams = texels_of(seam).map(|texel| SeamHit::new(texel, depth(texel), info, surface));
        self.buffers.seams.extend(seams);
        for (row, texels) in rows_of(covered) {
            self.first.add_row(row, texels, &depths[row], info, near.surface);
        }
        if surface.solid && covered != 0 {
            let leaves = !shape.faces_sun;
            let one = if leaves { -1 } else { 1 };
            for (row, texels) in rows_of(covered) {
                for (c, entered) in self.entered[row].iter_mut().enumerate() {
                    *entered += one & texels[c];
                }
            }
            let (low, high) = (near.low, near.high);
            self.buffers.crossings.push(Crossings { covered, leaves, low, high, depths });
        }
    }

    #[inline(always)]
    fn center(&self, texel: usize) -> [f64; 2] {
        [self.centers[0][texel % BLOCK_SIDE], self.centers[1][texel / BLOCK_SIDE]]
    }

    #[inline(always)]
    fn add_seams(&mut self, order: &[Near]) {
        let Self { first, buffers, block, .. } = self;
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
            if surface < first.get(texel) {
                first.set(texel, surface);
            }
        });
    }

    /// Adds masked surfaces where they cover enough of a texel and are nearest.
    fn add_masked(&mut self) {
        if self.buffers.masked.is_empty() {
            return;
        }
        let mut first: [FirstSurface; TEXELS] = std::array::from_fn(|texel| self.first.get(texel));
        masked::add_first_surfaces(&mut self.buffers.masked, &mut first);
        for (texel, &first) in first.iter().enumerate() {
            if first != self.first.get(texel) {
                self.first.set(texel, first);
            }
        }
    }

    /// Writes to `base` the depth behind which other receivers matter: the end of the solid that is hit first, or the
    /// first surface itself.
    #[inline(always)]
    fn resolve_solids(&mut self) {
        self.base = self.first.depth;
        let solid = texels_where(|texel| self.first.get(texel).is_solid());
        let crossings = &self.buffers.crossings;
        let (mut crossed, mut ends) = (0, [[FixedDepth::MAX; BLOCK_SIDE]; BLOCK_SIDE]);
        for end in crossings {
            crossed |= end.covered;
            if !end.leaves {
                continue;
            }
            let undecided = solid & texels_where(|texel| ends.as_flattened()[texel] >= end.low);
            // It is the end of the columns that have by then left what they entered.
            for (row, texels) in rows_of(end.covered & undecided) {
                let (mut inside, at) = ([0; BLOCK_SIDE], &end.depths[row]);
                for other in crossings.iter().take_while(|other| other.low <= end.high) {
                    let texels = other.covered >> (BLOCK_SIDE * row) & 0xff;
                    let (covered, one) = (&LANES[texels as usize], if other.leaves { -1 } else { 1 });
                    for c in 0..BLOCK_SIDE {
                        let counted = one & covered[c];
                        inside[c] += if other.depths[row][c] <= at[c] { counted } else { 0 };
                    }
                }
                for c in 0..BLOCK_SIDE {
                    let is_end = (texels[c] != 0) & (inside[c] <= 0);
                    let depth = if is_end { at[c] } else { FixedDepth::MAX };
                    ends[row][c] = depth.min(ends[row][c]);
                }
            }
        }
        let ended = texels_where(|texel| ends.as_flattened()[texel] != FixedDepth::MAX);
        for row in 0..BLOCK_SIDE {
            for c in 0..BLOCK_SIDE {
                let end = ends[row][c];
                self.base[row][c] = if end == FixedDepth::MAX { self.base[row][c] } else { end };
            }
        }
        for texel in texels_of(solid & crossed & !ended) {
            self.first.set_open(texel);
        }
    }

    /// Finds, for each column with a first surface, the nearest depth at which a receiver behind its base samples it.
    /// Something behind all bases is sampled at `known_behind` or deeper.
    #[inline(always)]
    fn ask_all(&mut self, order: &[Near], known_behind: FixedDepth) {
        let rules = *self.setting.rules;
        let asking = self.inside & self.first.met();
        for row in 0..BLOCK_SIDE {
            for c in 0..BLOCK_SIDE {
                let first = FirstSurface::new(self.first.depth[row][c], self.first.info[row][c]);
                let (base, deepest) = (self.base[row][c], self.deepest[row][c]);
                let exit = rules.exit(first, base);
                let is_free = rules.latest_switch(exit) == FREE_TO_END;
                let shadowed_from = if is_free { FixedDepth::MAX } else { exit.saturating_add(BEHIND_EXIT) };
                let farthest = shadowed_from.max(base.saturating_add(SUBTEXEL as FixedDepth));
                let next = if deepest > farthest { known_behind.min(deepest) } else { known_behind };
                let any_counts = (next == FixedDepth::MAX) & rules.assume_ground;
                self.shadowed_from[row][c] = shadowed_from;
                self.next[row][c] = if first.is_none() { FixedDepth::MAX } else { next };
                self.matters_before[row][c] =
                    if any_counts { FixedDepth::MAX } else { shadowed_from.min(next) };
            }
        }
        let nearest = |depths: &Texels<FixedDepth>| {
            let mut nearest = FixedDepth::MAX;
            for (t, &depth) in depths.as_flattened().iter().enumerate() {
                nearest = nearest.min(if asking >> t & 1 == 1 { depth } else { FixedDepth::MAX });
            }
            nearest
        };
        let (base_low, first_low) = (nearest(&self.base), nearest(&self.first.depth));
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
            let (owner, before) = (self.first.owner.as_flattened(), self.matters_before.as_flattened());
            let base = self.base.as_flattened();
            let may_matter = texels_where(|t| {
                (owner[t] != near.surface) & (range.lifted_low < before[t]) & (range.deepest > base[t])
            });
            let wanted = asking & within_reach & may_matter;
            if wanted != 0 {
                self.ask(wanted, surface);
                any_matters_before = self.any_matters_before(asking);
            }
        }
    }

    /// Returns the largest of [`Self::matters_before`] over these texels.
    #[inline(always)]
    fn any_matters_before(&self, asking: u64) -> FixedDepth {
        let mut farthest = FixedDepth::MIN;
        for (texel, &depth) in self.matters_before.as_flattened().iter().enumerate() {
            farthest = farthest.max(if asking >> texel & 1 == 1 { depth } else { FixedDepth::MIN });
        }
        farthest
    }

    /// Returns the columns, with no regard to filters.
    #[inline(always)]
    fn columns(&self) -> BlockColumns {
        let rules = *self.setting.rules;
        let mut columns = BlockColumns::free();
        for row in 0..BLOCK_SIDE {
            let inside = &LANES[(self.inside >> (BLOCK_SIDE * row) & 0xff) as usize];
            for c in 0..BLOCK_SIDE {
                let first = FirstSurface::new(self.first.depth[row][c], self.first.info[row][c]);
                let [e, x] = rules.column(first, self.base[row][c], self.next[row][c]);
                let texel = row * BLOCK_SIDE + c;
                columns.e[texel] = if inside[c] != 0 { e } else { columns.e[texel] };
                columns.x[texel] = if inside[c] != 0 { x } else { columns.x[texel] };
            }
        }
        columns
    }

    /// Bounds the columns where filters around surfaces near them read.
    #[inline(always)]
    fn bound(&self, near: NearSurfaces<'_>, columns: &mut BlockColumns) {
        let rules = *self.setting.rules;
        let can_be_bounded = |columns: &BlockColumns| {
            self.inside & texels_where(|t| columns.x[t] > ColumnRules::contact_from(columns.e[t]))
        };
        let mut open = can_be_bounded(columns);
        let margins = rules.contact_margins();
        let (mut nearest_from, mut farthest_x) = (u32::MAX, 0);
        for (texel, (&e, &x)) in columns.e.iter().zip(&columns.x).enumerate() {
            let is_open = open >> texel & 1 == 1;
            nearest_from = nearest_from.min(if is_open { ColumnRules::contact_from(e) } else { u32::MAX });
            farthest_x = farthest_x.max(if is_open { x } else { 0 });
        }
        let half_side = (BLOCK_SIDE - 1) as f64 / 2.0;
        let [x, y] = [0, 1].map(|axis| self.centers[axis][0] + half_side);
        for &s in near.list.iter().chain(near.beside) {
            if open == 0 {
                return;
            }
            let surface = &self.setting.surfaces[s as usize];
            let Some(receiver) = surface.receiver else { continue };
            let (z, rise) = (receiver.plane.at(x, y), half_side * receiver.plane.gradient_sum());
            if rules.contact_at(&receiver, z + rise + ROUNDING) < nearest_from
                || rules.contact_at(&receiver, z - rise - ROUNDING) >= farthest_x
            {
                continue;
            }
            let shape = &surface.surface.shape;
            let near =
                open & shape.centers_within_box(self.block.x, self.block.y, margins[CONTACT_RINGS - 1]);
            let mut contacts = [[0; BLOCK_SIDE]; BLOCK_SIDE];
            for (row, _) in rows_of(near) {
                let z = receiver.plane.along(&self.centers[0], self.centers[1][row]);
                for (contact, z) in contacts[row].iter_mut().zip(z) {
                    *contact = rules.contact_at(&receiver, z);
                }
            }
            let contacts = contacts.as_flattened();
            let wanted = near
                & texels_where(|t| {
                    (contacts[t] >= ColumnRules::contact_from(columns.e[t])) & (contacts[t] < columns.x[t])
                });
            if wanted == 0 {
                continue;
            }
            let reached = shape.coverage(self.block.x, self.block.y, margins);
            for texel in texels_of(wanted & reached[CONTACT_RINGS - 1]) {
                let ring = reached.iter().filter(|mask| **mask >> texel & 1 == 0).count();
                columns.x[texel] =
                    ColumnRules::bounded([columns.e[texel], columns.x[texel]], ring, contacts[texel]);
            }
            open = can_be_bounded(columns);
        }
    }

    /// Evaluates `surface` as a receiver for the texels in `wanted`.
    #[inline(always)]
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
                let (base, first) = (self.base[row][column], self.first.get(texel));
                let triangle = (&surface.shape, receiver);
                let next = rules.receiver_behind(ReceiverKind::Footprint, triangle, at, base, first);
                if next < self.next[row][column] {
                    self.next[row][column] = next;
                    self.matters_before[row][column] = next.min(self.shadowed_from[row][column]);
                }
            }
        }
    }
}
