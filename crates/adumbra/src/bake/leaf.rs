//! The columns of one 8 × 8 block, from the surfaces near it: what `capture.rs` finds for a tile, but a block at a time, in bit
//! masks, and asking for receivers only where an answer depends on them.
//!
//! A column whose first surface bounds a solid needs to know whether anything lies behind the solid, not where; a surface
//! sampled there says so at once. What is left to ask is about open first surfaces.

use super::block::{Block, BlockSurface};
use super::columns::{self, ColumnRules, FirstSurface, ReceiverKind};
use super::masked::{self, MaskedHit, TriangleMask};
use super::project::{FixedDepth, Projected, fixed_depth};
use super::sink::{BLOCK_SIDE, BlockColumns};
use super::surface::Surface;
use crate::light::LightGrid;
use crate::scene::Scene;

const TEXELS: usize = BLOCK_SIDE * BLOCK_SIDE;
/// A sampled depth that is behind a threshold by more than this is behind it however it is computed, 1/256 voxel.
const CERTAINLY_BEHIND: FixedDepth = 2;

/// Buffers that one worker reuses from block to block.
#[derive(Default)]
pub(super) struct LeafBuffers {
    /// Texel, and key of a solid's crossing.
    crossings: Vec<(u8, u32)>,
    sorted: Vec<u32>,
    masked: Vec<MaskedHit>,
}

/// The columns while they are found.
struct Leaf<'b> {
    first: [FirstSurface; TEXELS],
    /// The deepest sample of a column.
    deepest: [FixedDepth; TEXELS],
    base: [FixedDepth; TEXELS],
    next: [FixedDepth; TEXELS],
    buffers: &'b mut LeafBuffers,
}

/// Columns of `block`, which has level 3, as [`super::columns::ColumnRules::column`] of what lies over them; `inside` are the
/// texels of the grid. For [`Receivers::All`](crate::settings::Receivers::All).
pub(super) fn leaf_columns(
    block: &Block,
    inside: u64,
    surfaces: &[BlockSurface],
    list: &[u32],
    place: (&Scene, &LightGrid, &ColumnRules),
    buffers: &mut LeafBuffers,
) -> BlockColumns {
    let (scene, grid, rules) = place;
    buffers.crossings.clear();
    buffers.masked.clear();
    let mut leaf = Leaf {
        first: [FirstSurface::NONE; TEXELS],
        deepest: [FixedDepth::MIN; TEXELS],
        base: [0; TEXELS],
        next: [FixedDepth::MAX; TEXELS],
        buffers,
    };
    let near = || list.iter().map(|&s| &surfaces[s as usize].surface);
    for surface in near().filter(|s| s.casts) {
        leaf.sample(block, inside, surface, scene, grid, rules);
    }
    masked::add_first_surfaces(&mut leaf.buffers.masked, &mut leaf.first);
    leaf.resolve_solids();
    let (asking, threshold) = leaf.asking(inside);
    if asking != 0 {
        for surface in near() {
            leaf.ask(block, asking, threshold, &surface.shape, rules);
        }
    }
    let mut columns = BlockColumns::free();
    for texel in bits(inside) {
        [columns.e[texel], columns.x[texel]] =
            rules.column(leaf.first[texel], leaf.base[texel], leaf.next[texel]);
    }
    columns
}

impl Leaf<'_> {
    fn sample(
        &mut self,
        block: &Block,
        inside: u64,
        surface: &Surface,
        scene: &Scene,
        grid: &LightGrid,
        rules: &ColumnRules,
    ) {
        let shape = &surface.shape;
        let Some(plane) = shape.plane else { return };
        let covered = shape.coverage(block.x, block.y) & inside;
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
            self.first[texel] = self.first[texel].min(FirstSurface::new(depth, info));
            self.deepest[texel] = self.deepest[texel].max(depth);
            if surface.solid {
                self.buffers.crossings.push((texel as u8, columns::crossing_key(depth, exit_bit)));
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

    /// The texels that must know what lies behind their base, and the smallest depth that counts as behind one of them. Where
    /// a solid is known to have something behind it, `next` says so.
    fn asking(&mut self, inside: u64) -> (u64, FixedDepth) {
        let (mut asking, mut smallest) = (0, FixedDepth::MAX);
        for texel in bits(inside) {
            let first = self.first[texel];
            if first.is_none() {
                continue;
            }
            let threshold = self.base[texel].saturating_add(first.bias());
            if first.is_solid() && self.deepest[texel] > threshold.saturating_add(CERTAINLY_BEHIND) {
                self.next[texel] = self.deepest[texel];
            } else {
                asking |= 1 << texel;
                smallest = smallest.min(threshold);
            }
        }
        (asking, smallest)
    }

    /// `shape` as a receiver, for the texels of `asking`; nothing at or nearer than `threshold` is behind any of them.
    fn ask(
        &mut self,
        block: &Block,
        asking: u64,
        threshold: FixedDepth,
        shape: &Projected,
        rules: &ColumnRules,
    ) {
        let kind = ReceiverKind::Everywhere;
        let half = kind.footprint_half_texels();
        let side = BLOCK_SIDE as f64 / 2.0;
        let middle = [f64::from(block.x) + side, f64::from(block.y) + side];
        let [_, high] = shape.range_near(middle, side + half);
        if fixed_depth(high) + CERTAINLY_BEHIND <= threshold {
            return;
        }
        for row in 0..BLOCK_SIDE {
            let wanted = asking >> (row * BLOCK_SIDE) & 0xff;
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
