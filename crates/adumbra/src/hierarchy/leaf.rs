//! 8 × 8 columns: their intervals sorted into as few depths, or parallel planes, as will do, then depths chosen and written as half-words.

use super::choose::{FREE_TO_END, holds_any, intersection};
use super::code::{LEAF_NEVER, LEAF_SLANTED, LEAF_WIDTH};
use super::slant::{Slant, candidates};
use crate::bake::sink::BlockColumns;

/// Columns of a leaf.
const COLUMNS: usize = 64;

/// A leaf whose depths are still intervals.
#[derive(Debug)]
pub(super) struct Leaf {
    /// How all its depths change from column to column.
    slant: Slant,
    /// Intervals of the depths behind the first, ascending and apart.
    later: Vec<[u32; 2]>,
    /// Whether there is a last one that never switches.
    never: bool,
    /// Bits of each column's rank, the lowest first.
    planes: Vec<u64>,
}

/// What became of a block of columns: an interval for its base, and the rest where one depth does not do.
pub(super) fn sort_columns(columns: &BlockColumns) -> ([u32; 2], Option<Leaf>) {
    let intervals: [[u32; 2]; COLUMNS] = std::array::from_fn(|i| [columns.e[i], columns.x[i]]);
    let all = intersection(intervals);
    if holds_any(all) {
        return (all, None);
    }
    let mut best = sort_intervals(&intervals, Slant::default());
    if best.1.is_outline() {
        return (best.0, Some(best.1));
    }
    for slant in candidates(&intervals) {
        let slanted = std::array::from_fn(|i| {
            let rise = slant.rise(i as u32);
            intervals[i].map(|depth| depth.saturating_add(rise))
        });
        let found = sort_intervals(&slanted, slant);
        if found.1.length() < best.1.length() {
            best = found;
        }
    }
    (best.0, Some(best.1))
}

/// As few depths as stab all intervals, which have been moved by the slant's rise.
fn sort_intervals(intervals: &[[u32; 2]; COLUMNS], slant: Slant) -> ([u32; 2], Leaf) {
    let mut by_end: [u8; COLUMNS] = std::array::from_fn(|i| i as u8);
    by_end.sort_unstable_by_key(|&i| (intervals[i as usize][1], i));
    let mut ranks = [u8::MAX; COLUMNS];
    let mut depths: Vec<[u32; 2]> = Vec::new();
    // Each as late as the first interval left allows.
    for &first in &by_end {
        let point = intervals[first as usize][1];
        if ranks[first as usize] != u8::MAX || point == FREE_TO_END {
            continue;
        }
        let mut depth = [0, point];
        for (interval, rank) in intervals.iter().zip(&mut ranks) {
            if *rank == u8::MAX && interval[0] <= point && interval[1] != FREE_TO_END {
                *rank = depths.len() as u8;
                depth[0] = depth[0].max(interval[0]);
            }
        }
        depths.push(depth);
    }
    let last = depths.len() - 1;
    let endless = intervals.iter().zip(&ranks).filter(|(_, rank)| **rank == u8::MAX).map(|(i, _)| *i);
    let with_endless = intersection(endless.chain([depths[last]]));
    let never = !holds_any(with_endless);
    if !never {
        depths[last] = with_endless;
    }
    let last = last + usize::from(never);
    ranks.iter_mut().filter(|r| **r == u8::MAX).for_each(|r| *r = last as u8);
    let first = depths.remove(0);
    let planes = (0..usize::BITS - last.leading_zeros())
        .map(|p| (0..COLUMNS).fold(0, |plane, i| plane | u64::from(ranks[i] >> p & 1) << i))
        .collect();
    (first, Leaf { slant, later: depths, never, planes })
}

impl Leaf {
    /// Whether it is one depth and what never switches: no slant makes it shorter.
    fn is_outline(&self) -> bool {
        self.later.is_empty()
    }

    /// About how many half-words it takes.
    fn length(&self) -> usize {
        let slanted = usize::from(self.slant != Slant::default());
        1 + slanted + self.later.len().div_ceil(2) + 4 * self.planes.len()
    }

    /// Its half-words for a base inside the first interval; the other depths are the nearest that may be.
    pub(super) fn encode(&self, base: u32, halves: &mut Vec<u16>) {
        let depths = std::iter::once(base).chain(self.later.iter().map(|interval| interval[0]));
        let differences: Vec<u32> =
            depths.zip(&self.later).map(|(before, interval)| interval[0] - before).collect();
        let width = match differences.iter().max() {
            None | Some(0..=0xff) => 0,
            Some(0x100..=0xffff) => 1,
            Some(_) => 2_u16,
        };
        let last = differences.len() as u16 + u16::from(self.never);
        let never = if self.never { LEAF_NEVER as u16 } else { 0 };
        halves.clear();
        let slanted = self.slant != Slant::default();
        let slanted_bit = if slanted { LEAF_SLANTED as u16 } else { 0 };
        halves.push(last | never | width << LEAF_WIDTH | slanted_bit);
        if slanted {
            halves.push(self.slant.to_half());
        }
        match width {
            0 => halves.extend(differences.chunks(2).map(|d| (d[0] | d.get(1).unwrap_or(&0) << 8) as u16)),
            1 => halves.extend(differences.iter().map(|&d| d as u16)),
            _ => halves.extend(differences.iter().flat_map(|&d| [d as u16, (d >> 16) as u16])),
        }
        halves.extend(self.planes.iter().flat_map(|&p| [0, 16, 32, 48].map(|shift| (p >> shift) as u16)));
    }
}
