//! Rectangles of a texture that are opaque or clear throughout, by a summed-area table of opaque corners (Crow,
//! *Summed-area tables for texture mapping*, 1984).

use adumbra_scene::Wrap;

use super::OpacityTable;
use crate::triangles::project::floor_to_integer;

/// Coordinates beyond this are not looked up: their fractions are too coarse.
const LARGEST_COORDINATE: f64 = 4096.0;
/// Relative error of a sample's texture coordinates.
const RELATIVE_ERROR: f64 = 1.0 / (1 << 21) as f64;
/// Their error in texels, apart from that.
const ERROR_TEXELS: f64 = 1.0 / 256.0;
/// Numbers of corners from this one on do not fit the table.
const TOO_MANY_CORNERS: u32 = 1 << 16;

/// Ranges of cells along one axis.
struct Ranges<const N: usize> {
    first: [u32; N],
    last: [u32; N],
    /// 0 where a range is not known: the texture begins again within it.
    known: [u32; N],
}

/// Which of several rectangles are uniform, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Uniform {
    pub(crate) opaque: u16,
    pub(crate) clear: u16,
}

/// Returns the number of opaque ones among the corners above and to the left of each, modulo 2^16.
pub(super) fn count(corners: &[u8], width: usize, is_opaque: impl Fn(u8) -> bool) -> Vec<u16> {
    let mut counts = vec![0_u16; width + 1];
    counts.reserve_exact((corners.len() / width.max(1)) * (width + 1));
    for row in corners.chunks_exact(width.max(1)) {
        let above = counts.len() - (width + 1);
        let mut in_row = 0_u16;
        counts.push(0);
        for (x, &alpha) in row.iter().enumerate() {
            in_row = in_row.wrapping_add(u16::from(is_opaque(alpha)));
            counts.push(counts[above + x + 1].wrapping_add(in_row));
        }
    }
    counts
}

impl OpacityTable {
    /// Returns which of the `wanted` ones of N rectangles are opaque or clear at every sample in them. They have these
    /// centres and reach this far from them, texture coordinates. Neither: it is mixed, or not known.
    #[inline(always)]
    pub(crate) fn uniform<const N: usize>(
        &self,
        wanted: u16,
        [u, v]: [[f64; N]; 2],
        [reach_u, reach_v]: [f64; 2],
    ) -> Uniform {
        let (columns, rows) = (self.ranges(0, u, reach_u), self.ranges(1, v, reach_v));
        let mut found = Uniform::default();
        for i in (0..N).filter(|i| wanted >> i & 1 == 1) {
            if columns.known[i] & rows.known[i] == 0 {
                continue;
            }
            let state = self.is_uniform([columns.first[i], columns.last[i]], [rows.first[i], rows.last[i]]);
            found.opaque |= u16::from(state == Some(true)) << i;
            found.clear |= u16::from(state == Some(false)) << i;
        }
        found
    }

    /// Returns whether these cells, the last ones included, are all opaque or all clear.
    #[inline(always)]
    fn is_uniform(&self, [left, right]: [u32; 2], [top, bottom]: [u32; 2]) -> Option<bool> {
        let corners = if self.nearest { 1 } else { 2 };
        let (width, height) = (right - left + corners, bottom - top + corners);
        let number = width.saturating_mul(height);
        if number >= TOO_MANY_CORNERS {
            return None;
        }
        let row_length = self.width + 1;
        let (above, below) = (top as usize * row_length, (bottom + corners) as usize * row_length);
        let (left, right) = (left as usize, (right + corners) as usize);
        let at = |place: usize| self.counts.get(place).copied().unwrap_or_default();
        let in_rows_above = at(above + right).wrapping_sub(at(above + left));
        let opaque = at(below + right).wrapping_sub(at(below + left)).wrapping_sub(in_rows_above);
        match u32::from(opaque) {
            0 => Some(false),
            opaque if opaque == number => Some(true),
            _ => None,
        }
    }

    #[inline(always)]
    fn ranges<const N: usize>(&self, axis: usize, mut center: [f64; N], reach: f64) -> Ranges<N> {
        let size = f64::from(self.size[axis]);
        let (mut low, mut high, mut known) = ([0.0; N], [0.0; N], [0; N]);
        let mut reaches = [0.0; N];
        for i in 0..N {
            let largest = center[i].abs() + reach;
            // Does not hold if it is not a number.
            let is_known = largest <= LARGEST_COORDINATE;
            known[i] = u32::from(is_known);
            center[i] = if is_known { center[i] } else { 0.0 };
            reaches[i] =
                if is_known { reach + (largest + 1.0) * RELATIVE_ERROR + ERROR_TEXELS / size } else { 0.0 };
        }
        match self.wrap[axis] {
            Wrap::Clamp => {}
            Wrap::Repeat => {
                for i in 0..N {
                    center[i] -= center[i].floor();
                    let within = (center[i] >= reaches[i]) & (center[i] + reaches[i] <= 1.0);
                    known[i] &= u32::from(within);
                }
            }
            // What is beyond a border is the mirror image of a part of the range before it.
            Wrap::Mirror => {
                for c in &mut center {
                    let along_two = *c - 2.0 * (*c * 0.5).floor();
                    *c = if along_two > 1.0 { 2.0 - along_two } else { along_two };
                }
            }
        }
        for i in 0..N {
            [low[i], high[i]] = [center[i] - reaches[i], center[i] + reaches[i]].map(|c| {
                let positive = if c > 0.0 { c } else { 0.0 };
                if positive < 1.0 { positive } else { 1.0 }
            });
        }
        let (offset, last) =
            if self.nearest { (0.0, self.size[axis].saturating_sub(1)) } else { (0.5, self.size[axis]) };
        let cell = |c: f64| (floor_to_integer(c * size + offset) as u32).min(last);
        let mut ranges = Ranges { first: [0; N], last: [0; N], known };
        for i in 0..N {
            (ranges.first[i], ranges.last[i]) = (cell(low[i]), cell(high[i]));
        }
        ranges
    }
}
