//! Leaves as numbers, and the outlines that predict their neighbours.

use crate::layout::depths::code::{LEAF_NEVER, LEAF_SLANTED, LEAF_WIDTH, LeafHead};

/// Stands for [`NEVER`](crate::layout::depths::NEVER) in an [`Outline`], whose depths are relative to a base.
pub(super) const NEVER_CELL: u32 = 1 << 31;

/// Largest number of half-words of a leaf.
pub(super) const MOST_HALVES: usize = 2 + 126 + 24;

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
        let stored = &halves[head.differences_at() as usize..];
        for (i, difference) in leaf.differences[..head.differences() as usize].iter_mut().enumerate() {
            *difference = difference_at(stored, head.width, i);
            if *difference == 0 {
                return None;
            }
        }
        for (plane, words) in halves[head.planes_at() as usize..].chunks(4).enumerate() {
            for (c, rank) in leaf.ranks.iter_mut().enumerate() {
                *rank |= ((words[c / 16] >> (c % 16) & 1) << plane) as u8;
            }
        }
        (leaf.halves(&mut [0; MOST_HALVES]) == halves).then_some(leaf)
    }

    /// Writes the half-words in their shortest form.
    #[inline]
    pub(super) fn halves<'b>(&self, buffer: &'b mut [u16; MOST_HALVES]) -> &'b [u16] {
        let slanted = self.slant != 0;
        let differences = &self.differences[..self.stored()];
        let bits = differences.iter().fold(0, |bits, difference| bits | difference);
        let width = u32::from(bits > 0xff) + u32::from(bits > 0xffff);
        let never = if self.never { LEAF_NEVER } else { 0 };
        buffer[0] = (self.last | never | width << LEAF_WIDTH | if slanted { LEAF_SLANTED } else { 0 }) as u16;
        buffer[1] = self.slant as u16;
        let mut at = 1 + usize::from(slanted);
        match width {
            0 => {
                for two in differences.chunks(2) {
                    buffer[at] = (two[0] | two.get(1).unwrap_or(&0) << 8) as u16;
                    at += 1;
                }
            }
            1 => {
                for &difference in differences {
                    buffer[at] = difference as u16;
                    at += 1;
                }
            }
            _ => {
                for &difference in differences {
                    buffer[at] = difference as u16;
                    buffer[at + 1] = (difference >> 16) as u16;
                    at += 2;
                }
            }
        }
        for plane in 0..32 - self.last.leading_zeros() {
            for sixteen in self.ranks.as_chunks::<16>().0 {
                // One bit of each byte, gathered by a multiplication.
                let four = |ranks: &[u8]| {
                    let bytes = u32::from_le_bytes([ranks[0], ranks[1], ranks[2], ranks[3]]);
                    (bytes >> plane & 0x0101_0101).wrapping_mul(0x0102_0408) >> 24 & 15
                };
                let half = four(&sixteen[..4]) | four(&sixteen[4..8]) << 4;
                buffer[at] = (half | four(&sixteen[8..12]) << 8 | four(&sixteen[12..]) << 12) as u16;
                at += 1;
            }
        }
        &buffer[..at]
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

/// Returns difference `index` of those that `stored` begins with, of 8 << `width` bits each.
#[inline(always)]
fn difference_at(stored: &[u16], width: u32, index: usize) -> u32 {
    match width {
        0 => u32::from(stored[index / 2]) >> (8 * (index & 1)) & 0xff,
        1 => stored[index].into(),
        _ => u32::from(stored[2 * index]) | u32::from(stored[2 * index + 1]) << 16,
    }
}

/// Returns a gradient's quarters of a voxel per column along x and y.
#[inline(always)]
pub(super) fn gradient(slant: u32) -> [i32; 2] {
    [slant as u8 as i8, (slant >> 8) as u8 as i8].map(i32::from)
}

/// Returns 3 more than four times the [`rise`] of a plane, so that a shift by 2 rounds it up.
#[inline(always)]
pub(super) fn quarters(slant: u32, x: i32, y: i32) -> i32 {
    let along = |g: i32, at: i32| g * (at - if g > 0 { 7 } else { 0 });
    let [gx, gy] = gradient(slant);
    3 - along(gx, x) - along(gy, y)
}

/// Returns how much nearer to the sun a plane is in a column than at its deepest corner. The column may be in
/// a neighbouring leaf.
#[inline(always)]
pub(super) fn rise(slant: u32, x: i32, y: i32) -> u32 {
    (quarters(slant, x, y) >> 2) as u32
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
        let stored = &halves[head.differences_at() as usize..];
        let mut depth = 0_u32;
        for (i, slot) in depths[1..=head.differences() as usize].iter_mut().enumerate() {
            depth = depth.wrapping_add(difference_at(stored, head.width, i));
            *slot = depth;
        }
        let mut ranks = [0_u8; 16];
        for (plane, words) in halves[head.planes_at() as usize..].as_chunks::<4>().0.iter().enumerate() {
            for i in 0..8 {
                ranks[i] |= ((words[3] >> (8 + i) & 1) << plane) as u8;
                ranks[8 + i] |= ((words[i / 2] >> (8 * (i & 1) + 7) & 1) << plane) as u8;
            }
        }
        let mut cells = ranks.map(|rank| depths[rank as usize & 63]);
        if slant != 0 {
            for (i, (cell, rank)) in cells.iter_mut().zip(ranks).enumerate() {
                let [x, y] = if i < 8 { [i as i32, 7] } else { [7, i as i32 - 8] };
                if u32::from(rank) <= head.differences() {
                    *cell = cell.wrapping_sub(rise(slant.into(), x, y));
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
