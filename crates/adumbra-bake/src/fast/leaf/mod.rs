//! The columns of one 8 × 8 block, from the surfaces near it. The result is that of `capture.rs` for the
//! block's texels, but computed a block at a time in bit masks, and receivers are evaluated only if an answer
//! depends on them.
//!
//! A column needs to know whether a receiver is behind its base, and whether one samples it nearer than its
//! exit. A surface that is sampled far behind a solid settles the first question at once. The remaining work
//! concerns open first surfaces and thin gaps.

mod masks;
mod receivers;
mod sampling;
mod texels;

use texels::{Firsts, LANES, Texels};

use std::cell::OnceCell;

use crate::columns::masked::TriangleMask;
use crate::columns::rules::{ColumnRules, FirstSurface};
use crate::columns::seams::SeamHit;
use crate::columns::{BLOCK_SIDE, BlockColumns};
use crate::fast::block::{Block, BlockSurface, SurfaceRange};
use crate::triangles::depth::FixedDepth;
use crate::triangles::opacity::OpacityTables;
use adumbra::grid::LightGrid;
use adumbra_scene::Scene;

/// The surfaces near the block.
#[derive(Clone, Copy)]
pub(crate) struct NearSurfaces<'a> {
    /// Indices into [`Setting::surfaces`].
    pub(crate) list: &'a [u32],
    /// Depth bounds over the block of each surface in the list.
    pub(crate) ranges: &'a [SurfaceRange],
    /// Indices into [`Setting::surfaces`] of receivers farther away, whose filters may read the block's
    /// columns.
    pub(crate) beside: &'a [u32],
}

/// A surface near the block, with its depth range there.
#[derive(Clone, Copy)]
struct Near {
    low: FixedDepth,
    high: FixedDepth,
    surface: u32,
    /// Index into the list.
    place: u32,
}

impl Near {
    /// Returns a word that sorts by `low`, then `high`.
    fn key(&self) -> u64 {
        let ordered = |depth: FixedDepth| u64::from(depth as u32 ^ 1 << 31);
        ordered(self.low) << 32 | ordered(self.high)
    }
}

/// Buffers that a worker reuses from block to block.
#[derive(Default)]
pub(crate) struct LeafBuffers {
    /// Nearest first.
    order: Vec<Near>,
    /// Nearest first, by the least depth.
    crossings: Vec<Crossings>,
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

/// The mask of a surface. It is `None` for a surface that is edge-on to the light.
pub(crate) type LazyMask = OnceCell<Option<Box<TriangleMask>>>;

/// The inputs shared by all leaves of a root block.
#[derive(Clone, Copy)]
pub(crate) struct Setting<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) grid: &'a LightGrid,
    pub(crate) rules: &'a ColumnRules,
    pub(crate) surfaces: &'a [BlockSurface],
    /// Where materials with holes are opaque.
    pub(crate) opacity: &'a OpacityTables,
    /// The masks of those surfaces that have holes, made when they are first sampled. Empty if none has.
    pub(crate) masks: &'a [LazyMask],
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
    /// A receiver that samples the column at this depth or deeper cannot change it: either a nearer one is
    /// known, or the column is known to have a receiver and is in shadow by then anyway.
    matters_before: Texels<FixedDepth>,
    /// Texel centres, by column and by row.
    centers: [[f64; BLOCK_SIDE]; 2],
    buffers: &'b mut LeafBuffers,
}

/// Computes the columns of `block`, which has level 3, by [`crate::columns::rules::ColumnRules::column`].
/// `inside` is the set of texels in the grid. Some receiver behind every first surface, and behind every
/// solid that is hit first, is sampled at `known_behind` or deeper; [`FixedDepth::MAX`] if no such receiver
/// is known. For [`Receivers::All`](adumbra::Receivers::All).
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

    /// Inlined, like all loops over texels below it, into a function that is compiled for the widest vectors
    /// at hand. No result depends on them.
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> BlockColumns {
        compute(self)
    }
}

#[inline(always)]
fn compute(Task { block, inside, near, known_behind, setting, buffers }: Task<'_>) -> BlockColumns {
    buffers.crossings.clear();
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
        // No result depends on the order of surfaces with equal ranges.
        self.order.sort_unstable_by_key(|near| near.key());
    }
}

impl Leaf<'_> {
    /// Returns the columns, with no regard to filters.
    #[inline(always)]
    fn columns(&self) -> BlockColumns {
        let rules = *self.setting.rules;
        let mut columns = BlockColumns::free();
        for row in 0..BLOCK_SIDE {
            let inside = &LANES[(self.inside >> (BLOCK_SIDE * row) & 0xff) as usize];
            for (c, &inside) in inside.iter().enumerate() {
                let first = FirstSurface::new(self.first.depth[row][c], self.first.info[row][c]);
                let [e, x] = rules.column(first, self.base[row][c], self.next[row][c]);
                let texel = row * BLOCK_SIDE + c;
                columns.e[texel] = if inside != 0 { e } else { columns.e[texel] };
                columns.x[texel] = if inside != 0 { x } else { columns.x[texel] };
            }
        }
        columns
    }
}
