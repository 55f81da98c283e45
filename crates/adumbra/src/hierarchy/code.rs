//! Reading shapes from half-words. The words must have been validated.

use super::slant::Slant;
use super::{LEAF_LEVEL, NEVER, NODE_LEVELS, UNIFORM};

/// Addresses that a near pointer names outright are below this; it is its highest bit too.
pub(super) const NEAR: u32 = 1 << 15;

/// Bit of a leaf's first half-word: its last depth is [`NEVER`].
pub(super) const LEAF_NEVER: u32 = 1 << 6;
/// Where the width of its differences stands in it.
pub(super) const LEAF_WIDTH: u32 = 7;
/// Bit of it: a gradient follows.
pub(super) const LEAF_SLANTED: u32 = 1 << 9;

/// What holds a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// It and its neighbours switch at this depth.
    Uniform(u32),
    /// A leaf's address and base.
    Leaf { at: u32, base: u32 },
}

/// What a node says of a child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Child {
    Never,
    /// All switch at the base plus this.
    Uniform(u32),
    /// A shape's address, and what its base has more, wrapping.
    Shape {
        at: u32,
        delta: u32,
    },
}

/// Sizes of a leaf's parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LeafHead {
    /// The last rank: depths less one.
    pub(super) last: u32,
    pub(super) never: bool,
    /// Differences take 8 << width bits.
    pub(super) width: u32,
    pub(super) slanted: bool,
}

impl LeafHead {
    pub(super) fn new(half: u32) -> Self {
        Self {
            last: half & 63,
            never: half & LEAF_NEVER != 0,
            width: half >> LEAF_WIDTH & 3,
            slanted: half & LEAF_SLANTED != 0,
        }
    }

    /// Depths that are differences: all but the base and [`NEVER`].
    pub(super) fn differences(self) -> u32 {
        self.last - u32::from(self.never)
    }

    /// Half-words before the differences.
    pub(super) fn differences_at(self) -> u32 {
        1 + u32::from(self.slanted)
    }

    /// Half-words before the planes.
    pub(super) fn planes_at(self) -> u32 {
        self.differences_at() + (self.differences() << self.width).div_ceil(2)
    }

    pub(super) fn planes(self) -> u32 {
        32 - self.last.leading_zeros()
    }

    /// Half-words in all.
    pub(super) fn length(self) -> u32 {
        self.planes_at() + 4 * self.planes()
    }
}

/// Words with shapes in them.
#[derive(Clone, Copy)]
pub(super) struct Code<'c> {
    pub(super) words: &'c [u32],
    pub(super) wide: &'c [[u32; 2]],
}

impl<'c> Code<'c> {
    pub(super) fn half(self, at: u32) -> u32 {
        self.words[(at >> 1) as usize] >> (16 * (at & 1)) & 0xffff
    }

    pub(super) fn two_halves(self, at: u32) -> u32 {
        self.half(at) | self.half(at + 1) << 16
    }

    fn four_halves(self, at: u32) -> u64 {
        u64::from(self.two_halves(at)) | u64::from(self.two_halves(at + 2)) << 32
    }

    /// A child of the node at `at`.
    pub(super) fn child(self, at: u32, child: u32) -> Child {
        let [low, high, kind] = [0, 1, 2].map(|h| self.half(at + h));
        let below = (1 << child) - 1;
        let field = at + 3 + (low & below).count_ones() + 2 * (high & below).count_ones();
        let delta = |at| i32::from(self.half(at) as i16) as u32;
        match (high >> child & 1, low >> child & 1, kind >> child & 1) {
            (0, 0, 0) => Child::Uniform(0),
            (0, 0, _) => Child::Never,
            (0, _, 0) => Child::Shape { at: self.near(at, field), delta: 0 },
            (0, ..) => Child::Uniform(delta(field)),
            (_, 0, 0) => Child::Shape { at: self.two_halves(field), delta: 0 },
            (_, 0, _) => Child::Shape { at: self.near(at, field + 1), delta: delta(field) },
            (_, _, 0) => Child::Shape { at: self.two_halves(field + 1), delta: delta(field) },
            _ => match self.wide[self.two_halves(field) as usize] {
                [delta, UNIFORM] => Child::Uniform(delta),
                [delta, at] => Child::Shape { at, delta },
            },
        }
    }

    fn near(self, from: u32, field: u32) -> u32 {
        let half = self.half(field);
        if half & NEAR == 0 { half } else { from.wrapping_sub(half & (NEAR - 1)) }
    }

    /// From a root of `level` to what holds the column, and its level.
    pub(super) fn descend(
        self,
        mut at: u32,
        mut base: u32,
        mut level: u32,
        [i, j]: [u32; 2],
    ) -> (Place, u32) {
        if at == UNIFORM {
            return (Place::Uniform(base), level);
        }
        while level > LEAF_LEVEL {
            level -= NODE_LEVELS;
            match self.child(at, (j >> level & 3) << 2 | i >> level & 3) {
                Child::Never => return (Place::Uniform(NEVER), level),
                Child::Uniform(delta) => return (Place::Uniform(base.wrapping_add(delta)), level),
                Child::Shape { at: next, delta } => {
                    at = next;
                    base = base.wrapping_add(delta);
                }
            }
        }
        (Place::Leaf { at, base }, level)
    }

    /// A leaf, for its columns and slabs.
    pub(super) fn leaf(self, at: u32, base: u32) -> LeafCode<'c> {
        let head = LeafHead::new(self.half(at));
        let slant = if head.slanted { Slant::from_half(self.half(at + 1)) } else { Slant::default() };
        LeafCode { code: self, at, base, head, slant }
    }
}

/// A leaf in the code.
#[derive(Clone, Copy)]
pub(super) struct LeafCode<'c> {
    code: Code<'c>,
    at: u32,
    base: u32,
    head: LeafHead,
    slant: Slant,
}

impl LeafCode<'_> {
    fn difference(self, index: u32) -> u32 {
        let first = self.at + self.head.differences_at();
        match self.head.width {
            0 => self.code.half(first + index / 2) >> (8 * (index & 1)) & 0xff,
            1 => self.code.half(first + index),
            _ => self.code.two_halves(first + 2 * index),
        }
    }

    fn plane(self, p: u32) -> u64 {
        self.code.four_halves(self.at + self.head.planes_at() + 4 * p)
    }

    /// Half-word that the differences do not fill; none where they do.
    pub(super) fn padding(self) -> Option<u32> {
        let padded = self.head.width == 0 && self.head.differences() & 1 == 1;
        padded.then(|| self.code.half(self.at + self.head.planes_at() - 1))
    }

    /// Depth at which a column switches. Depths end at 0 and at [`NEVER`].
    pub(super) fn value(self, column: u32) -> u32 {
        let bit = |p| u32::from(self.plane(p) >> column & 1 == 1);
        let rank = (0..self.head.planes()).fold(0, |rank, p| rank | bit(p) << p);
        if rank > self.head.differences() {
            return NEVER;
        }
        let depth = (0..rank).fold(self.base, |depth, d| depth.saturating_add(self.difference(d)));
        depth.saturating_sub(self.slant.rise(column))
    }

    /// Columns that are lit at depth k.
    pub(super) fn slab(self, k: u32) -> u64 {
        let largest_rise = self.slant.largest_rise();
        // Ranks that are dark all over, and the columns of others that are.
        let (mut dark_ranks, mut dark) = (0, 0);
        let mut depth = self.base;
        for rank in 0..=self.head.differences() {
            if rank > 0 {
                depth = depth.saturating_add(self.difference(rank - 1));
            }
            if k.saturating_add(largest_rise) < depth {
                break;
            }
            if depth <= k {
                dark_ranks += 1;
            } else {
                dark |= self.of_rank(rank) & !self.slant.below(depth - k);
            }
        }
        !dark & self.at_least(dark_ranks)
    }

    /// [`LeafCode::slab`] of eight depths from `first` on.
    pub(super) fn cube(self, first: u32) -> [u64; 8] {
        let largest_rise = self.slant.largest_rise();
        let mut lit = [0; 8];
        let mut depth = self.base;
        for rank in 0..=self.head.differences() {
            if rank > 0 {
                depth = depth.saturating_add(self.difference(rank - 1));
            }
            if first.saturating_add(7 + largest_rise) < depth {
                let columns = self.at_least(rank);
                return lit.map(|slab| slab | columns);
            }
            if depth > first {
                let columns = self.of_rank(rank);
                for (slab, k) in lit.iter_mut().zip(first..depth.min(first.saturating_add(8))) {
                    let rise = depth - k;
                    *slab |= if rise > largest_rise { columns } else { columns & self.slant.below(rise) };
                }
            }
        }
        let never = self.at_least(self.head.differences() + 1);
        lit.map(|slab| slab | never)
    }

    /// Columns whose rank is above the last one. A valid leaf has none.
    pub(super) fn without_depth(self) -> u64 {
        self.at_least(self.head.last + 1)
    }

    /// Columns of one rank.
    fn of_rank(self, rank: u32) -> u64 {
        (0..self.head.planes())
            .fold(u64::MAX, |mask, p| mask & if rank >> p & 1 == 1 { self.plane(p) } else { !self.plane(p) })
    }

    /// Columns of at least this rank: all 64 compared at once, the highest bit first.
    fn at_least(self, rank: u32) -> u64 {
        if rank >> self.head.planes() != 0 {
            return 0;
        }
        let (mut more, mut equal) = (0, u64::MAX);
        for p in (0..self.head.planes()).rev() {
            let plane = self.plane(p);
            if rank >> p & 1 == 0 {
                more |= equal & plane;
                equal &= !plane;
            } else {
                equal &= plane;
            }
        }
        more | equal
    }
}
