//! Rectangles of a texture that are opaque or clear throughout, by a summed-area table of opaque corners (Crow,
//! *Summed-area tables for texture mapping*, 1984).

use adumbra_scene::Wrap;

use super::OpacityTable;
use super::sample::whole;

/// Coordinates beyond this are not looked up: their fractions are too coarse.
const LARGEST_COORDINATE: f32 = 64.0;
/// Error of a sample's texture coordinates, and of the arithmetic here, relative to the largest of them.
const RELATIVE_ERROR: f64 = 1.0 / (1 << 21) as f64;
/// Their error in texels, apart from that.
const ERROR_TEXELS: f64 = 1.0 / 256.0;
/// More than the rounding of a reach, relative to it.
const REACH_ERROR: f64 = 1e-6;
/// Numbers of corners from this one on do not fit the table.
const TOO_MANY_CORNERS: f64 = 65_536.0;

/// The size of rectangles of a texture.
#[derive(Clone, Copy)]
pub(crate) struct Window {
    /// How far they reach from their centres along u and v, cells.
    reach: [f32; 2],
    /// Number of cells after the first that they may be in.
    span: [u32; 2],
}

/// Ranges of cells along one axis.
struct Ranges<const N: usize> {
    first: [u32; N],
    /// Number of corners in the range.
    corners: [u32; N],
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
    /// Returns the window of rectangles that reach this far from their centres, texture coordinates. Returns `None` if
    /// they are too large to be looked up.
    #[inline(always)]
    pub(crate) fn window(&self, reach: [f64; 2]) -> Option<Window> {
        let mut window = Window { reach: [0.0; 2], span: [0; 2] };
        let mut corners = 1.0;
        for axis in 0..2 {
            let size = f64::from(self.size[axis]);
            let error = (f64::from(LARGEST_COORDINATE) + 1.0) * RELATIVE_ERROR * size + ERROR_TEXELS;
            let reach = reach[axis] * size * (1.0 + REACH_ERROR) + error;
            corners *= 2.0 * reach + 4.0;
            window.reach[axis] = reach as f32;
            window.span[axis] = ((2.0 * window.reach[axis]) as u32).saturating_add(1);
        }
        // Does not hold if it is not a number.
        (corners < TOO_MANY_CORNERS).then_some(window)
    }

    /// Returns which of N rectangles around these centres are opaque or clear at every sample in them. Neither: it is
    /// mixed, or not known.
    #[inline(always)]
    pub(crate) fn uniform<const N: usize>(&self, [u, v]: &[[f32; N]; 2], window: &Window) -> Uniform {
        let (columns, rows) = (self.ranges(0, u, window), self.ranges(1, v, window));
        let row_length = self.width as u32 + 1;
        let mut places = [[0_u32; N]; 4];
        #[expect(clippy::needless_range_loop, reason = "it runs over several arrays at once")]
        for i in 0..N {
            let first = rows.first[i] * row_length + columns.first[i];
            let below = first + rows.corners[i] * row_length;
            places[0][i] = first;
            places[1][i] = first + columns.corners[i];
            places[2][i] = below;
            places[3][i] = below + columns.corners[i];
        }
        let mut counts = [[0_u16; N]; 4];
        for (counts, places) in counts.iter_mut().zip(&places) {
            for (count, &place) in counts.iter_mut().zip(places) {
                *count = self.counts.get(place as usize).copied().unwrap_or_default();
            }
        }
        let (mut opaque, mut clear) = ([0_u32; N], [0_u32; N]);
        for i in 0..N {
            let [a, b, c, d] = [counts[0][i], counts[1][i], counts[2][i], counts[3][i]];
            let found = u32::from(d.wrapping_sub(c).wrapping_sub(b).wrapping_add(a));
            let known = columns.known[i] & rows.known[i];
            opaque[i] = if found == columns.corners[i] * rows.corners[i] { known << i } else { 0 };
            clear[i] = if found == 0 { known << i } else { 0 };
        }
        let all = |bits: [u32; N]| bits.into_iter().fold(0, |all, bit| all | bit) as u16;
        Uniform { opaque: all(opaque), clear: all(clear) }
    }

    #[inline(always)]
    fn ranges<const N: usize>(&self, axis: usize, centers: &[f32; N], window: &Window) -> Ranges<N> {
        let (size, reach, span) = (self.size[axis] as f32, window.reach[axis], window.span[axis]);
        let (mut center, mut known) = (*centers, [0; N]);
        for (c, known) in center.iter_mut().zip(&mut known) {
            // Does not hold if it is not a number.
            let is_known = c.abs() <= LARGEST_COORDINATE;
            *known = u32::from(is_known);
            *c = if is_known { *c } else { 0.0 };
        }
        match self.wrap[axis] {
            Wrap::Clamp => {}
            Wrap::Repeat => {
                for (c, known) in center.iter_mut().zip(&mut known) {
                    *c -= c.floor();
                    let texels = *c * size;
                    *known &= u32::from((texels >= reach) & (texels + reach <= size));
                }
            }
            // What is beyond a border is the mirror image of a part of the range before it.
            Wrap::Mirror => center.iter_mut().for_each(|c| {
                let along_two = *c - 2.0 * (*c * 0.5).floor();
                *c = if along_two > 1.0 { 2.0 - along_two } else { along_two };
            }),
        }
        let (offset, last, beyond) = if self.nearest {
            (0.0, self.size[axis].saturating_sub(1), 1)
        } else {
            (0.5, self.size[axis], 2)
        };
        let last_cell = last as f32;
        let mut ranges = Ranges { first: [0; N], corners: [0; N], known };
        #[expect(clippy::needless_range_loop, reason = "it runs over several arrays at once")]
        for i in 0..N {
            let low = center[i] * size + offset - reach;
            let low = if low > 0.0 { low } else { 0.0 };
            let first = whole((if low < last_cell { low } else { last_cell }).floor());
            ranges.first[i] = first;
            ranges.corners[i] = span.min(last - first) + beyond;
        }
        ranges
    }
}
