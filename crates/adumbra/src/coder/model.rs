//! All adaptive probabilities, each with its context, and the codes of numbers and depths.

use super::contour::class;
use super::rans::{Bit, Coder, Symbol};
use crate::layout::depths::NEVER;

/// A number: its length in bits, its second and third highest bit, and the rest.
#[derive(Clone, Copy)]
pub(super) struct Number {
    /// The length, or 15 for that and more.
    length: Symbol,
    /// By length.
    second: [Bit; 16],
    /// By length and the second highest bit.
    third: [Bit; 32],
    /// Whether the number is negative, by its size up to 4.
    sign: [Bit; 4],
}

impl Number {
    const NEW: Self =
        Self { length: Symbol::NEW, second: [Bit::NEW; 16], third: [Bit::NEW; 32], sign: [Bit::NEW; 4] };

    /// Codes a number of up to 32 bits.
    pub(super) fn code<C: Coder>(&mut self, coder: &mut C, number: u32) -> u32 {
        let length = 32 - number.leading_zeros();
        let class = coder.symbol(&mut self.length, length.min(15));
        if class < 2 {
            return class;
        }
        let more = if class == 15 { coder.plain(5, length.wrapping_sub(15) & 31).min(17) } else { 0 };
        let mut left = class + more - 2;
        let mut value = 2 | coder.bit(&mut self.second[class as usize], number >> left & 1);
        if left > 0 {
            left -= 1;
            let third = &mut self.third[(2 * class + (value & 1)) as usize];
            value = value << 1 | coder.bit(third, number >> left & 1);
            value = value << left | coder.plain(left, number & ((1 << left) - 1));
        }
        value
    }

    /// Codes a number in two's complement: its absolute value, then its sign.
    pub(super) fn signed<C: Coder>(&mut self, coder: &mut C, number: u32) -> u32 {
        let size = self.code(coder, (number as i32).unsigned_abs());
        let negative = size != 0 && coder.bit(&mut self.sign[size.min(4) as usize - 1], number >> 31) == 1;
        if negative { size.wrapping_neg() } else { size }
    }
}

/// A depth that may equal one of six known depths.
#[derive(Clone, Copy)]
pub(super) struct Depth {
    /// Index of the known depth that it equals, or the length of its distance. The context: which known
    /// depths are equal.
    way: [Symbol; 64],
    /// Whether it is less, by length.
    sign: [Bit; 16],
    /// The second highest bit of the distance, by length.
    second: [Bit; 16],
}

impl Depth {
    const NEW: Self = Self { way: [Symbol::NEW; 64], sign: [Bit::NEW; 16], second: [Bit::NEW; 16] };

    /// Codes a depth. The last of the known ones is the parent's base.
    pub(super) fn code<C: Coder>(&mut self, coder: &mut C, known: [u32; 6], depth: u32) -> u32 {
        let [a, b, c, d, _, base] = known;
        let context = usize::from(a == b)
            | usize::from(a == c) << 1
            | usize::from(b == d) << 2
            | usize::from(a == base) << 3
            | usize::from(a == NEVER) << 4
            | usize::from(b == NEVER) << 5;
        let origin = [a, b].into_iter().find(|&depth| depth != NEVER).unwrap_or(base);
        let step = depth.wrapping_sub(origin);
        let size = (step as i32).unsigned_abs();
        let length = 32 - size.leading_zeros();
        let way = match known.iter().position(|&known| known == depth) {
            Some(index) => index as u32,
            None => 5 + length.min(10),
        };
        let way = coder.symbol(&mut self.way[context], way);
        if way < 6 {
            return known[way as usize];
        }
        // A distance of 1 to 9 bits, or of 10 and more.
        let class = way - 5;
        let negative = coder.bit(&mut self.sign[class as usize], step >> 31) == 1;
        let more = if class == 10 { coder.plain(5, length.wrapping_sub(10) & 31).min(22) } else { 0 };
        let mut left = class + more - 1;
        let mut value = 1;
        if left > 0 {
            left -= 1;
            value = 2 | coder.bit(&mut self.second[class as usize], size >> left & 1);
            value = value << left | coder.plain(left, size & ((1 << left) - 1));
        }
        origin.wrapping_add(if negative { value.wrapping_neg() } else { value })
    }
}

/// All probabilities. Each part begins with new ones.
pub(super) struct Model {
    /// Number of shapes of a common section.
    pub(super) count: Number,
    /// Level of each of them, as (level − 3) / 2.
    pub(super) level: Symbol,
    /// State of a child, by level, by whether there are leaves above and to the left, and by the classes of
    /// their edges.
    pub(super) state: [[[Symbol; class::COUNT * class::COUNT]; 4]; 4],
    /// Place of a shape in the order of last use, by level.
    pub(super) reference: [Symbol; 4],
    /// Its number among the shapes of its level, by level and by whether it is the part's own.
    pub(super) number: [[Number; 2]; 4],
    /// Depth of a uniform child, by level.
    pub(super) uniform: [Depth; 4],
    /// Base of a node, by level.
    pub(super) node: [Depth; 4],
    /// Base of a leaf, by whether it is slanted, and by whether it has more than two depths.
    pub(super) leaf: [Depth; 4],
    /// Head of a leaf, by the neighbours above and to the left.
    pub(super) head: [Symbol; 36],
    /// Last rank from 4 on, and from 8 on.
    pub(super) last: [Symbol; 2],
    /// For such a leaf: whether its last depth is never, and whether it is slanted, by whether its last depth
    /// is never.
    pub(super) never: [Bit; 2],
    pub(super) slanted: [[Bit; 2]; 2],
    /// Gradient, by those above and to the left.
    pub(super) slant: [Symbol; 3],
    /// Change of the gradient along x and y.
    pub(super) gradient: [Number; 2],
    /// Whether a difference leads to the next facing depth: by index, last rank and slanted, and by distance.
    pub(super) difference_hit: [[Bit; 8]; 24],
    /// A difference less 1, by index, last rank and slanted.
    pub(super) difference: [Number; 24],
    /// Whether a row after a flat one is equal to it: by last rank, row, and whether the row before differed.
    pub(super) still: [[[Bit; 2]; 8]; 3],
    /// Which of four columns change: by last rank, and by the steps of the row above, the column to the left,
    /// and the changes of the row above.
    pub(super) row: [[Symbol; 640]; 3],
    /// The rank to which a column changes: by last rank, and by the ranks to the left and to the upper right.
    pub(super) value: [[Symbol; 48]; 4],
}

impl Model {
    /// Returns the probabilities with which every part begins.
    pub(super) fn new() -> Box<Self> {
        Box::new(Self {
            count: Number::NEW,
            level: Symbol::NEW,
            state: [[[Symbol::NEW; class::COUNT * class::COUNT]; 4]; 4],
            reference: [Symbol::NEW; 4],
            number: [[Number::NEW; 2]; 4],
            uniform: [Depth::NEW; 4],
            node: [Depth::NEW; 4],
            leaf: [Depth::NEW; 4],
            head: [Symbol::NEW; 36],
            last: [Symbol::NEW; 2],
            never: [Bit::NEW; 2],
            slanted: [[Bit::NEW; 2]; 2],
            slant: [Symbol::NEW; 3],
            gradient: [Number::NEW; 2],
            difference_hit: [[Bit::NEW; 8]; 24],
            difference: [Number::NEW; 24],
            still: [[[Bit::NEW; 2]; 8]; 3],
            row: [[Symbol::NEW; 640]; 3],
            value: [[Symbol::NEW; 48]; 4],
        })
    }
}
