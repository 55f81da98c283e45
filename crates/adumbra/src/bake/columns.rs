//! What a column allows: the specification's §3, one rule a function.
//!
//! A column has an *entry* (first surface from the light) and an *exit*; the switch from lit to shadowed may be put
//! anywhere between. Voxel k is defined lit where k < e, defined shadowed where k >= x, else free, with
//! `e = ceil(entry - 1/2)` and `x = max(e, ceil(exit - 1/2))`. A column with no surface has e = the grid's length; an x
//! at or beyond the grid's end is [`FREE_TO_END`].

use super::project::{FixedDepth, SUBTEXEL};
use crate::settings::{Bias, MAX_SLOPE, Receivers};

/// Depth steps added before a depth becomes an unsigned key.
const KEY_OFFSET: i64 = 1 << 28;

/// The nearest surface of a column, ordered by depth, then solids before open surfaces, then small bias first.
///
/// | bits | meaning |
/// |---|---|
/// | 63..32 | depth in 1/256 voxel plus 2^28 |
/// | 31 | 1 = open, 0 = bounds a solid |
/// | 15..0 | bias at the surface's slope, 1/256 voxel |
///
/// Worked value: an open surface at depth 2 with a bias of 1.5 voxels is `0x1000_0200_8000_0180`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct FirstSurface(u64);

const OPEN_BIT: u64 = 1 << 31;

impl FirstSurface {
    /// No surface at all.
    pub(crate) const NONE: Self = Self(u64::MAX);

    pub(crate) fn new(depth: FixedDepth, info: u32) -> Self {
        Self(((i64::from(depth) + KEY_OFFSET) as u64) << 32 | u64::from(info))
    }

    pub(crate) fn is_none(self) -> bool {
        self == Self::NONE
    }

    pub(crate) fn is_solid(self) -> bool {
        self.0 & OPEN_BIT == 0
    }

    pub(crate) fn set_open(&mut self) {
        self.0 |= OPEN_BIT;
    }

    /// Depth; [`FixedDepth::MAX`] where there is no surface.
    pub(crate) fn depth(self) -> FixedDepth {
        if self.is_none() { FixedDepth::MAX } else { ((self.0 >> 32) as i64 - KEY_OFFSET) as FixedDepth }
    }

    /// Bias at the surface's slope, 1/256 voxel.
    pub(crate) fn bias(self) -> FixedDepth {
        (self.0 & 0xffff) as FixedDepth
    }
}

/// A solid's crossing as a sortable word: depth plus 2^28 in bits 31..1, bit 0 = 1 where the solid is left.
pub(crate) fn crossing_key(depth: FixedDepth, exit_bit: u32) -> u32 {
    ((i64::from(depth) + KEY_OFFSET) as u32) << 1 | exit_bit
}

/// Depth at which the winding count of sorted crossings is back at zero; none where it goes negative or never
/// returns: then the column is open.
pub(crate) fn solid_end(sorted: &[u32]) -> Option<FixedDepth> {
    let mut inside = 0_u32;
    for &key in sorted {
        if key & 1 == 0 {
            inside += 1;
        } else {
            inside = inside.checked_sub(1)?;
            if inside == 0 {
                return Some((i64::from(key >> 1) - KEY_OFFSET) as FixedDepth);
            }
        }
    }
    None
}

/// Calls `visit(from, to)` with every interval of positive winding of sorted crossings, `to` outside; none where the
/// count goes negative: then the column is open. What is entered and never left is no interval.
pub(crate) fn for_each_inside(sorted: &[u32], mut visit: impl FnMut(FixedDepth, FixedDepth)) {
    let depth = |key: u32| (i64::from(key >> 1) - KEY_OFFSET) as FixedDepth;
    let step = |key: u32| if key & 1 == 0 { 1 } else { -1 };
    let mut winding = 0;
    for &key in sorted {
        winding += step(key);
        if winding < 0 {
            return;
        }
    }
    let (mut winding, mut from) = (0, 0);
    for &key in sorted {
        if winding == 0 {
            from = depth(key);
        }
        winding += step(key);
        if winding == 0 && depth(key) > from {
            visit(from, depth(key));
        }
    }
}

/// The choices of a bake that decide a column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ColumnRules {
    pub(crate) bias: Bias,
    /// How far below an open surface a shadow may begin, voxels; the bias at the slope if that is more.
    pub(crate) thickness_voxels: f64,
    pub(crate) assume_ground: bool,
    pub(crate) receivers: Receivers,
    /// Voxels along the light.
    pub(crate) depth_voxels: u32,
}

/// The x of a column in which no voxel of the grid must be shadowed; so does [`BESIDE_GRID`].
pub(crate) const FREE_TO_END: u32 = u32::MAX - 1;
/// The x of what is no column of the grid, e = 0: nobody asks it.
pub(crate) const BESIDE_GRID: u32 = u32::MAX;

/// Half side of the footprint of a texel, with 1/256 for the snapping.
pub(crate) const FOOTPRINT_HALF: f64 = 0.5 + 1.0 / SUBTEXEL as f64;
/// Texels beside a static receiver that a filter may read: a 9 × 9 filter's reach.
const STATIC_FILTER_REACH: f64 = 4.0;
/// Distance between the outermost taps that share a depth: eight texels of one block.
const STATIC_FILTER_TAPS_REACH: f64 = 7.0;

/// What makes a surface near a column a receiver that the column must answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ReceiverKind {
    /// It lies in the texel's footprint; everything behind it matters too.
    Everywhere,
    /// It lies in the texel's footprint; only itself matters, lifted by its bias.
    Itself,
    /// A filter around it reads the column, at the depth of its plane there.
    Filtered,
}

impl ReceiverKind {
    /// Half the side of the square around a texel's centre in which a surface counts.
    pub(crate) fn footprint_half_texels(self) -> f64 {
        match self {
            Self::Everywhere | Self::Itself => FOOTPRINT_HALF,
            Self::Filtered => FOOTPRINT_HALF + STATIC_FILTER_REACH,
        }
    }
}

impl ColumnRules {
    /// How far outside its outline a triangle may matter to a column.
    pub(crate) fn reach_texels(&self) -> f64 {
        match self.receivers {
            Receivers::All => ReceiverKind::Everywhere.footprint_half_texels(),
            Receivers::Static => ReceiverKind::Filtered.footprint_half_texels(),
        }
    }

    /// Low word of a [`FirstSurface`].
    pub(crate) fn surface_info(&self, slope: f64, solid: bool) -> u32 {
        self.bias_fixed(slope) as u32 | if solid { 0 } else { OPEN_BIT as u32 }
    }

    /// Bias along the light at this slope, 1/256 voxel, at most 16 bits of it.
    pub(crate) fn bias_fixed(&self, slope: f64) -> FixedDepth {
        (self.bias.along_light(slope) * SUBTEXEL as f64).min(65_535.0) as FixedDepth
    }

    /// How far below an open surface a shadow may begin, 1/256 voxel.
    pub(crate) fn thickness_fixed(&self) -> FixedDepth {
        (self.thickness_voxels * SUBTEXEL as f64).min(1e9) as FixedDepth
    }

    /// Depths, in voxels, at which a surface of this slope asks a column: from the nearest that any look-up uses to the
    /// farthest that must not be taken for the column's own surface. `z` is its range over the texel's footprint,
    /// `z_plane` its plane at the texel's centre with the sum of its gradient's magnitudes. None where it does not ask.
    pub(crate) fn asked_depths(
        &self,
        kind: ReceiverKind,
        slope: f64,
        z: [f64; 2],
        z_plane: Option<(f64, f64)>,
    ) -> Option<[f64; 2]> {
        match kind {
            ReceiverKind::Everywhere => Some(z),
            ReceiverKind::Itself => Some([z[0] - self.bias.along_light(slope), z[1]]),
            ReceiverKind::Filtered => {
                let (z_plane, gradient_sum) = z_plane.filter(|_| slope < MAX_SLOPE)?;
                let nearest = self.bias.along_light(slope) + STATIC_FILTER_TAPS_REACH * gradient_sum;
                Some([z_plane - nearest, z_plane - STATIC_FILTER_REACH * gradient_sum])
            }
        }
    }

    /// The depth before which a column's shadow must have begun for a receiver that asks at `asked` voxels, or
    /// [`FixedDepth::MAX`] where no part of it lies behind the base by more than the bias at the first surface's slope.
    pub(crate) fn receiver_behind(
        &self,
        kind: ReceiverKind,
        base: FixedDepth,
        first: FirstSurface,
        asked: [f64; 2],
    ) -> FixedDepth {
        if first.is_none() {
            return FixedDepth::MAX;
        }
        let threshold = base + first.bias();
        if asked[1] * SUBTEXEL as f64 <= f64::from(threshold) {
            return FixedDepth::MAX;
        }
        let low = (asked[0] * SUBTEXEL as f64).floor().max(-1e9) as FixedDepth;
        low.max(if kind == ReceiverKind::Everywhere { threshold } else { base })
    }

    /// The latest x where only static receivers are answered, from the nearest depth at which one asks.
    pub(crate) fn static_end(&self, first: FirstSurface, next: FixedDepth) -> u32 {
        if first.is_none() || next == FixedDepth::MAX {
            return FREE_TO_END;
        }
        let x = self.quantize(next).max(self.quantize(first.depth()));
        if x < self.depth_voxels { x } else { FREE_TO_END }
    }

    /// The column's `[e, x]`: voxel k is defined lit where k < e and defined shadowed where k >= x.
    pub(crate) fn column(&self, first: FirstSurface, base: FixedDepth, next: FixedDepth) -> [u32; 2] {
        if first.is_none() {
            return [self.depth_voxels, FREE_TO_END];
        }
        let e = self.quantize(first.depth());
        let nothing_behind = next == FixedDepth::MAX;
        let exit = if nothing_behind && self.assume_ground {
            None
        } else if first.is_solid() {
            Some(base)
        } else {
            let thickness = self.open_thickness(first);
            let half_gap = if nothing_behind { FixedDepth::MAX } else { (next - first.depth()) / 2 };
            Some(first.depth().saturating_add(thickness.min(half_gap)))
        };
        [e, exit.map_or(FREE_TO_END, |exit| self.latest_switch(exit).max(e))]
    }

    /// How far below an open first surface its shadow may begin, were nothing behind it, 1/256 voxel.
    fn open_thickness(&self, first: FirstSurface) -> FixedDepth {
        self.thickness_fixed().max(first.bias())
    }

    /// A receiver at this depth behind an open first surface, or behind it, leaves it all its thickness.
    pub(crate) fn full_thickness_from(&self, first: FirstSurface) -> FixedDepth {
        first.depth().saturating_add(self.open_thickness(first).saturating_mul(2)).saturating_add(1)
    }

    /// x for an exit: [`FREE_TO_END`] at or beyond the grid's end.
    pub(crate) fn latest_switch(&self, exit: FixedDepth) -> u32 {
        let x = self.quantize(exit);
        if x < self.depth_voxels { x } else { FREE_TO_END }
    }

    /// `ceil(depth - 1/2)` in whole voxels, kept within the grid.
    pub(crate) fn quantize(&self, depth: FixedDepth) -> u32 {
        let steps = i64::from(depth) - SUBTEXEL / 2;
        let voxel = -(-steps).div_euclid(SUBTEXEL);
        voxel.clamp(0, i64::from(self.depth_voxels)) as u32
    }
}

/// `[e, x]` of every column of a tile.
#[derive(Default)]
pub(crate) struct Columns {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Where lit ends.
    pub(crate) e: Vec<u32>,
    /// Where shadow must have begun.
    pub(crate) x: Vec<u32>,
}

impl Columns {
    pub(crate) fn reset(&mut self, width: u32, height: u32) {
        self.width = width;
        self.height = height;
        for v in [&mut self.e, &mut self.x] {
            v.clear();
            v.resize((width * height) as usize, 0);
        }
    }

    pub(crate) fn set(&mut self, texel: usize, [e, x]: [u32; 2]) {
        self.e[texel] = e;
        self.x[texel] = x;
    }

    /// Lets a column's shadow begin as late as `x`.
    pub(crate) fn extend(&mut self, texel: usize, x: u32) {
        self.x[texel] = self.x[texel].max(x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Intervals of crossings given as (depth, is left).
    fn insides(crossings: &[(FixedDepth, bool)]) -> Vec<(FixedDepth, FixedDepth)> {
        let mut keys: Vec<_> = crossings.iter().map(|&(d, left)| crossing_key(d, u32::from(left))).collect();
        keys.sort_unstable();
        let mut found = Vec::new();
        for_each_inside(&keys, |from, to| found.push((from, to)));
        found
    }

    #[test]
    fn columns_lie_inside_solids_from_entering_to_leaving() {
        let (enters, leaves) = (|d| (d, false), |d| (d, true));
        assert_eq!(insides(&[]), []);
        assert_eq!(insides(&[enters(-5), leaves(9)]), [(-5, 9)]);
        // Nested, and one behind the other.
        let nested = [enters(10), enters(20), leaves(30), leaves(40), enters(50), leaves(60)];
        assert_eq!(insides(&nested), [(10, 40), (50, 60)]);
        // Abutting: entering comes before leaving at one depth, so there is no gap.
        assert_eq!(insides(&[enters(1), leaves(5), enters(5), leaves(8)]), [(1, 8)]);
        // Without thickness; never left; left before entered.
        assert_eq!(insides(&[enters(3), leaves(3)]), []);
        assert_eq!(insides(&[enters(1), leaves(2), enters(7)]), [(1, 2)]);
        assert_eq!(insides(&[leaves(0), enters(1), leaves(2)]), []);
    }
}
