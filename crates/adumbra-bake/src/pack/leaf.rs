//! 8 × 8 columns: their intervals are sorted into as few depths, or parallel planes, as suffice; then depths
//! are chosen and written as half-words.

use super::intervals::{COLUMNS, ENDLESS, Intervals};
use super::slant::candidates;
use crate::columns::BlockColumns;
use crate::pack::choose::{holds_any, intersection};
use crate::texel_mask::texels_where;
use adumbra::layout::depths::leaf::{self, MOST_HALVES};
use adumbra::layout::depths::slant::Slant;

/// A leaf whose depths are still intervals.
#[derive(Clone, Debug)]
pub(crate) struct Leaf {
    /// How all of its depths change from column to column.
    slant: Slant,
    /// Intervals of the depths after the first, ascending and disjoint.
    later: Vec<[u32; 2]>,
    /// Whether there is a last depth that never switches.
    never: bool,
    /// Bit planes of the columns' ranks, lowest bit first.
    planes: Vec<u64>,
}

/// Sorts a block of columns. Returns an interval for its base, and a leaf if one depth does not suffice. No
/// result depends on `arch`, the processor's vectors.
pub(crate) fn sort_columns(columns: &BlockColumns, arch: pulp::Arch) -> ([u32; 2], Option<Leaf>) {
    let all = intersection((0..COLUMNS).map(|i| [columns.e[i], columns.x[i]]));
    if holds_any(all) {
        return (all, None);
    }
    let (base, leaf) = arch.dispatch(SortColumns(columns));
    (base, Some(leaf))
}

/// The argument of the part of [`sort_columns`] that is compiled for the widest vectors at hand.
struct SortColumns<'a>(&'a BlockColumns);

impl pulp::WithSimd for SortColumns<'_> {
    type Output = ([u32; 2], Leaf);

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Self::Output {
        let intervals = Intervals::new(self.0);
        let mut best = Sorting::default();
        best.sort(&intervals, usize::MAX);
        // With one depth plus columns that never switch, no slant makes the leaf shorter.
        if best.count > 1 {
            let mut found = Sorting::default();
            for slant in candidates(&intervals) {
                if found.sort(&intervals.risen(slant), best.length()) {
                    std::mem::swap(&mut best, &mut found);
                }
                if best.count == 1 && !best.never {
                    break;
                }
            }
        }
        best.leaf()
    }
}

/// Intervals sorted into the fewest depths that stab them all.
struct Sorting {
    slant: Slant,
    /// Intervals of the depths, ascending and disjoint.
    depths: [[i32; 2]; COLUMNS],
    columns: [u64; COLUMNS],
    count: usize,
    /// Columns without an end: they never switch, or use the last depth.
    endless: u64,
    never: bool,
}

impl Default for Sorting {
    #[inline(always)]
    fn default() -> Self {
        let slant = Slant::default();
        Self { slant, depths: [[0; 2]; COLUMNS], columns: [0; COLUMNS], count: 0, endless: 0, never: false }
    }
}

impl Sorting {
    /// Sorts the intervals. Returns whether the leaf is shorter than `limit`. Previous contents are lost.
    #[inline(always)]
    fn sort(&mut self, intervals: &Intervals, limit: usize) -> bool {
        (self.slant, self.count, self.endless, self.never) = (intervals.slant, 0, 0, false);
        // Ends of the columns that have no depth yet.
        let mut ends = intervals.x;
        loop {
            // As deep as the first remaining interval allows.
            let point = ends.iter().fold(ENDLESS, |least, &x| least.min(x));
            if point == ENDLESS {
                break;
            }
            let is_here = |i: usize| (ends[i] != ENDLESS) & (intervals.e[i] <= point);
            let columns = texels_where(is_here);
            let mut nearest = 0;
            for i in 0..COLUMNS {
                nearest = nearest.max(if is_here(i) { intervals.e[i] } else { 0 });
            }
            for (end, &e) in ends.iter_mut().zip(&intervals.e) {
                *end = if e <= point { ENDLESS } else { *end };
            }
            self.depths[self.count] = [nearest, point];
            self.columns[self.count] = columns;
            self.count += 1;
            if self.length() >= limit {
                return false;
            }
        }
        self.endless = texels_where(|i| intervals.x[i] == ENDLESS);
        let mut nearest = 0;
        for i in 0..COLUMNS {
            nearest = nearest.max(if intervals.x[i] == ENDLESS { intervals.e[i] } else { 0 });
        }
        let last = &mut self.depths[self.count - 1];
        self.never = nearest > last[1];
        if !self.never {
            last[0] = last[0].max(nearest);
        }
        self.length() < limit
    }

    /// Returns the rank of the last depth.
    #[inline(always)]
    fn last(&self) -> usize {
        self.count - 1 + usize::from(self.never)
    }

    #[inline(always)]
    fn planes(&self) -> usize {
        (usize::BITS - self.last().leading_zeros()) as usize
    }

    /// Returns the approximate length in half-words.
    #[inline(always)]
    fn length(&self) -> usize {
        let slanted = usize::from(self.slant != Slant::default());
        1 + slanted + self.count.div_ceil(2) + 4 * self.planes()
    }

    #[inline(always)]
    fn leaf(&self) -> ([u32; 2], Leaf) {
        let plane = |p: usize| {
            let ranks = (0..self.count).filter(|r| r >> p & 1 == 1);
            let depths = ranks.fold(0, |plane, r| plane | self.columns[r]);
            depths | if self.last() >> p & 1 == 1 { self.endless } else { 0 }
        };
        let interval = |d: [i32; 2]| d.map(|depth| depth as u32);
        let later = self.depths[1..self.count].iter().map(|&d| interval(d)).collect();
        let planes = (0..self.planes()).map(plane).collect();
        (interval(self.depths[0]), Leaf { slant: self.slant, later, never: self.never, planes })
    }
}

impl Leaf {
    /// Writes the leaf's half-words for a base within the first interval. The other depths are the nearest
    /// allowed.
    pub(crate) fn encode<'b>(&self, base: u32, buffer: &'b mut [u16; MOST_HALVES]) -> &'b [u16] {
        let mut differences = [0; COLUMNS];
        let mut before = base;
        for (difference, interval) in differences.iter_mut().zip(&self.later) {
            *difference = interval[0] - before;
            before = interval[0];
        }
        leaf::encode(self.slant, self.never, &differences[..self.later.len()], &self.planes, buffer)
    }
}
