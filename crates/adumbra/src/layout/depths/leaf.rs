//! The half-words of a leaf, see [the table](super#leaves): where its parts are, and how it is written.

use crate::layout::depths::slant::Slant;

/// Bit of a leaf's first half-word: the last depth is [`NEVER`](super::NEVER).
const LEAF_NEVER: u32 = 1 << 6;
/// Lowest bit of the field of a leaf's first half-word that holds the width of the differences.
const LEAF_WIDTH: u32 = 7;
/// Bit of a leaf's first half-word: the leaf is slanted, and a gradient follows.
const LEAF_SLANTED: u32 = 1 << 9;

/// Largest number of half-words of a leaf.
pub const MOST_HALVES: usize = 2 + 126 + 24;
/// Largest number of bit planes of a leaf.
pub(crate) const MOST_PLANES: usize = 6;

/// The first half-word of a leaf, which determines the sizes of its parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeafHead {
    /// The last rank: the number of depths minus 1.
    pub last: u32,
    /// Whether the last depth is [`NEVER`](super::NEVER).
    pub never: bool,
    /// Differences take 8 << width bits each.
    pub width: u32,
    /// Whether the leaf is slanted, so that a gradient follows.
    pub slanted: bool,
}

impl LeafHead {
    /// Decodes a leaf's first half-word.
    pub fn new(half: u32) -> Self {
        Self {
            last: half & 63,
            never: half & LEAF_NEVER != 0,
            width: half >> LEAF_WIDTH & 3,
            slanted: half & LEAF_SLANTED != 0,
        }
    }

    /// Returns the number of depths stored as differences: all but the base and [`NEVER`](super::NEVER).
    pub fn differences(self) -> u32 {
        self.last - u32::from(self.never)
    }

    /// Returns the number of half-words before the differences.
    pub(crate) fn differences_at(self) -> u32 {
        1 + u32::from(self.slanted)
    }

    /// Returns the number of half-words before the planes.
    pub(crate) fn planes_at(self) -> u32 {
        self.differences_at() + (self.differences() << self.width).div_ceil(2)
    }

    /// Returns the number of bit planes of the columns' ranks.
    pub fn planes(self) -> u32 {
        32 - self.last.leading_zeros()
    }

    /// Returns the leaf's total number of half-words.
    pub fn length(self) -> u32 {
        self.planes_at() + 4 * self.planes()
    }

    /// Returns difference `index` of the leaf at `at`. `half` returns the half-word at an address.
    #[inline(always)]
    pub fn difference(self, at: u32, index: u32, half: impl Fn(u32) -> u32) -> u32 {
        let first = at + self.differences_at();
        match self.width {
            0 => half(first + index / 2) >> (8 * (index & 1)) & 0xff,
            1 => half(first + index),
            _ => half(first + 2 * index) | half(first + 2 * index + 1) << 16,
        }
    }

    /// Returns bit plane `p` of the leaf at `at`. `half` returns the half-word at an address.
    #[inline(always)]
    pub fn plane(self, at: u32, p: u32, half: impl Fn(u32) -> u32) -> u64 {
        let first = at + self.planes_at() + 4 * p;
        let two = |at: u32| u64::from(half(at) | half(at + 1) << 16);
        two(first) | two(first + 2) << 32
    }

    /// Returns the rank of each column of the leaf at `at`. `half` returns the half-word at an address.
    #[inline(always)]
    pub(crate) fn ranks(self, at: u32, half: impl Fn(u32) -> u32 + Copy) -> [u8; 64] {
        let mut ranks = [0_u8; 64];
        for p in 0..self.planes() {
            let plane = self.plane(at, p, half);
            for (column, rank) in ranks.iter_mut().enumerate() {
                *rank |= ((plane >> column & 1) as u8) << p;
            }
        }
        ranks
    }
}

/// Writes a leaf in its shortest form into `buffer`, and returns its half-words.
///
/// `differences` are those between successive depths, without that to a last depth that is
/// [`NEVER`](super::NEVER); `never` says whether there is one. `planes` are the bit planes of the columns'
/// ranks, as many as the last rank needs. The leaf is slanted if `slant` is not zero.
#[inline]
pub fn encode<'b>(
    slant: Slant,
    never: bool,
    differences: &[u32],
    planes: &[u64],
    buffer: &'b mut [u16; MOST_HALVES],
) -> &'b [u16] {
    let slanted = slant != Slant::default();
    let last = differences.len() as u32 + u32::from(never);
    debug_assert_eq!(planes.len() as u32, 32 - last.leading_zeros());
    let bits = differences.iter().fold(0, |bits, difference| bits | difference);
    let width = u32::from(bits > 0xff) + u32::from(bits > 0xffff);
    let flag = |is_set: bool, bit: u32| if is_set { bit } else { 0 };
    buffer[0] = (last | flag(never, LEAF_NEVER) | width << LEAF_WIDTH | flag(slanted, LEAF_SLANTED)) as u16;
    buffer[1] = slant.to_half();
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
    for plane in planes {
        for part in 0..4 {
            buffer[at + part] = (plane >> (16 * part)) as u16;
        }
        at += 4;
    }
    &buffer[..at]
}
