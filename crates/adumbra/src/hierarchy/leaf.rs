//! 8 × 8 columns: their intervals sorted into as few depths as will do, then depths chosen and written as half-words.

use super::choose::{FREE_TO_END, holds_any, intersection};
use super::code::{LEAF_NEVER, LEAF_WIDTH};
use crate::bake::sink::BlockColumns;

/// Columns of a leaf.
const COLUMNS: usize = 64;

/// A leaf whose depths are still intervals.
#[derive(Debug)]
pub(super) struct Leaf {
    /// Intervals of the depths behind the first, ascending and apart.
    later: Vec<[u32; 2]>,
    /// Whether there is a last one that never switches.
    never: bool,
    /// Bits of each column's rank, the lowest first.
    planes: Vec<u64>,
}

/// What became of a block of columns: an interval for its first depth, and the rest where one depth does not do.
pub(super) fn sort_columns(columns: &BlockColumns) -> ([u32; 2], Option<Leaf>) {
    let interval = |i: usize| [columns.e[i], columns.x[i]];
    let all = intersection((0..COLUMNS).map(interval));
    if holds_any(all) {
        return (all, None);
    }
    let mut by_end: [u8; COLUMNS] = std::array::from_fn(|i| i as u8);
    by_end.sort_unstable_by_key(|&i| (columns.x[i as usize], i));
    let mut ranks = [u8::MAX; COLUMNS];
    let mut depths: Vec<[u32; 2]> = Vec::new();
    // As few points as stab all intervals that end: each as late as the first interval allows.
    for &first in &by_end {
        let point = columns.x[first as usize];
        if ranks[first as usize] != u8::MAX || point == FREE_TO_END {
            continue;
        }
        let rank = depths.len() as u8;
        let taken = |i: usize, rank_of: u8| {
            rank_of == u8::MAX && columns.e[i] <= point && columns.x[i] != FREE_TO_END
        };
        let members = (0..COLUMNS).filter(|&i| taken(i, ranks[i]));
        depths.push(intersection(members.clone().map(interval)));
        let members = members.fold(0_u64, |mask, i| mask | 1 << i);
        ranks.iter_mut().enumerate().filter(|(i, _)| members >> i & 1 == 1).for_each(|(_, r)| *r = rank);
    }
    let last = depths.len() - 1;
    let endless = (0..COLUMNS).filter(|&i| ranks[i] == u8::MAX).map(interval);
    let with_endless = intersection(endless.chain([depths[last]]));
    let mut never = false;
    let mut endless_rank = last;
    if holds_any(with_endless) {
        depths[last] = with_endless;
    } else {
        never = true;
        endless_rank += 1;
    }
    ranks.iter_mut().filter(|r| **r == u8::MAX).for_each(|r| *r = endless_rank as u8);
    let first = depths.remove(0);
    let planes = (0..usize::BITS - endless_rank.leading_zeros())
        .map(|p| (0..COLUMNS).fold(0, |plane, i| plane | u64::from(ranks[i] >> p & 1) << i))
        .collect();
    (first, Some(Leaf { later: depths, never, planes }))
}

impl Leaf {
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
        halves.push(last | never | width << LEAF_WIDTH);
        match width {
            0 => halves.extend(differences.chunks(2).map(|d| (d[0] | d.get(1).unwrap_or(&0) << 8) as u16)),
            1 => halves.extend(differences.iter().map(|&d| d as u16)),
            _ => halves.extend(differences.iter().flat_map(|&d| [d as u16, (d >> 16) as u16])),
        }
        halves.extend(self.planes.iter().flat_map(|&p| [0, 16, 32, 48].map(|shift| (p >> shift) as u16)));
    }
}
