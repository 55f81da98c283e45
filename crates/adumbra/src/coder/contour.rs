//! Leaves as numbers, and the outlines that predict their neighbours.

use crate::layout::depths::leaf::{LeafHead, MOST_HALVES, MOST_PLANES, encode};
use crate::layout::depths::slant::{SLANT_BITS, Slant};

/// Stands for [`NEVER`](crate::layout::depths::NEVER) in an [`Outline`], whose depths are relative to a base.
pub(super) const NEVER_CELL: u32 = 1 << 31;

/// A leaf.
#[derive(Clone, Copy)]
pub(super) struct Leaf {
    /// The last rank: the number of depths minus 1.
    pub(super) last: u32,
    /// Whether the last depth is never.
    pub(super) never: bool,
    /// The gradient, as in a leaf's second half-word. 0 if the leaf is not slanted.
    pub(super) slant: u32,
    /// Differences of the depths, of which there are [`Leaf::stored`].
    pub(super) differences: [u32; 64],
    /// The rank of each column.
    pub(super) ranks: [u8; 64],
}

impl Leaf {
    /// An empty leaf, to be filled.
    pub(super) const EMPTY: Self =
        Self { last: 0, never: false, slant: 0, differences: [0; 64], ranks: [0; 64] };

    /// Returns the number of differences.
    #[inline(always)]
    pub(super) fn stored(&self) -> usize {
        (self.last - u32::from(self.never)) as usize
    }

    /// Returns 1 for one depth, 2 for one and never, 3 for two, 4 for three or four, and 5 for more.
    #[inline(always)]
    pub(super) fn kind(&self) -> u8 {
        kind_of(self.last, self.never)
    }

    /// Reads the half-words of a valid leaf. Returns `None` if [`Leaf::halves`] would write other half-words.
    pub(super) fn read(halves: &[u16]) -> Option<Self> {
        let head = LeafHead::new(halves[0].into());
        let mut leaf = Self { last: head.last, never: head.never, ..Self::EMPTY };
        if head.slanted {
            leaf.slant = halves[1].into();
        }
        let half = |at: u32| u32::from(halves[at as usize]);
        for (i, difference) in (0..head.differences()).zip(&mut leaf.differences) {
            *difference = head.difference(0, i, half);
            if *difference == 0 {
                return None;
            }
        }
        leaf.ranks = head.ranks(0, half);
        (leaf.halves(&mut [0; MOST_HALVES]) == halves).then_some(leaf)
    }

    /// Writes the half-words in their shortest form.
    #[inline]
    pub(super) fn halves<'b>(&self, buffer: &'b mut [u16; MOST_HALVES]) -> &'b [u16] {
        let mut planes = [0; MOST_PLANES];
        let planes = &mut planes[..(32 - self.last.leading_zeros()) as usize];
        for (p, plane) in planes.iter_mut().enumerate() {
            // One bit of each of eight bytes, gathered by a multiplication.
            let bits = |ranks: &[u8; 8]| {
                let bytes = u64::from_le_bytes(*ranks) >> p & 0x0101_0101_0101_0101;
                bytes.wrapping_mul(0x0102_0408_1020_4080) >> 56
            };
            *plane = self.ranks.as_chunks().0.iter().rev().fold(0, |plane, ranks| plane << 8 | bits(ranks));
        }
        let slant = Slant::from_half(self.slant);
        encode(slant, self.never, &self.differences[..self.stored()], planes, buffer)
    }
}

/// Returns the kind of a leaf, see [`Leaf::kind`].
#[inline(always)]
fn kind_of(last: u32, never: bool) -> u8 {
    match (last, never) {
        (0, _) => 1,
        (1, true) => 2,
        (1, false) => 3,
        (2..=3, _) => 4,
        _ => 5,
    }
}

/// Classes of an edge of eight columns that faces a block.
pub(super) mod class {
    /// Nothing is known.
    pub(in super::super) const UNKNOWN: u8 = 0;
    /// No column switches.
    pub(in super::super) const NEVER: u8 = 1;
    /// All columns switch at one depth.
    pub(in super::super) const FLAT: u8 = 2;
    /// All columns switch, at depths that differ by up to 16.
    pub(in super::super) const SMOOTH: u8 = 3;
    /// Anything else.
    pub(in super::super) const MIXED: u8 = 4;
    /// Number of classes.
    pub(in super::super) const COUNT: usize = 5;
}

/// The part of a leaf that predicts its neighbours.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outline {
    /// Depths of row 7, then of column 7, relative to the base, or [`NEVER_CELL`].
    pub(super) cells: [u32; 16],
    /// Classes of row 7 and column 7.
    pub(super) classes: [u8; 2],
    /// See [`Leaf::kind`].
    pub(super) kind: u8,
    /// The gradient, or 0.
    pub(super) slant: u16,
}

impl Outline {
    /// Returns the outline of a valid leaf from its half-words.
    #[inline]
    pub(super) fn of(halves: &[u16]) -> Self {
        let head = LeafHead::new(halves[0].into());
        let slant = if head.slanted { halves[1] } else { 0 };
        let mut depths = [NEVER_CELL; 64];
        depths[0] = 0;
        let half = |at: u32| u32::from(halves[at as usize]);
        let mut depth = 0_u32;
        for (i, slot) in (0..head.differences()).zip(&mut depths[1..]) {
            depth = depth.wrapping_add(head.difference(0, i, half));
            *slot = depth;
        }
        let mut ranks = [0_u8; 16];
        for p in 0..head.planes() {
            let plane = head.plane(0, p, half);
            for i in 0..8 {
                ranks[i] |= ((plane >> (56 + i) & 1) as u8) << p;
                ranks[8 + i] |= ((plane >> (8 * i + 7) & 1) as u8) << p;
            }
        }
        let mut cells = ranks.map(|rank| depths[rank as usize & 63]);
        if slant != 0 {
            let plane = Slant::from_half(slant.into());
            for (i, (cell, rank)) in cells.iter_mut().zip(ranks).enumerate() {
                let [x, y] = if i < 8 { [i as i32, 7] } else { [7, i as i32 - 8] };
                if u32::from(rank) <= head.differences() {
                    *cell = cell.wrapping_sub((plane.quarters(x, y) >> SLANT_BITS) as u32);
                }
            }
        }
        let classes = [class_of(&cells[..8]), class_of(&cells[8..])];
        Self { cells, classes, kind: kind_of(head.last, head.never), slant }
    }
}

#[inline(always)]
fn class_of(cells: &[u32]) -> u8 {
    let count = cells.iter().filter(|&&cell| cell == NEVER_CELL).count();
    let [mut least, mut most] = [cells[0] as i32; 2];
    for &cell in cells {
        least = least.min(cell as i32);
        most = most.max(cell as i32);
    }
    match count {
        0 if least == most => class::FLAT,
        0 if most.wrapping_sub(least) as u32 <= 16 => class::SMOOTH,
        8 => class::NEVER,
        _ => class::MIXED,
    }
}
