//! Reads shapes from half-words. The words must be valid.

use crate::layout::depths::child::{Child, ShapeRef};
use crate::layout::depths::leaf::LeafHead;
use crate::layout::depths::slant::Slant;
use crate::layout::depths::{LEAF_LEVEL, NEVER, NODE_LEVELS, UNIFORM};

/// Near pointers below this value are addresses in the common section. The others have this bit set and are
/// relative.
pub const NEAR: u32 = 1 << 15;
/// Far pointers have this bit set if they are relative.
pub const FAR: u32 = 1 << 31;
/// Number of bits of a far pointer's address or distance. The bits above, up to [`FAR`], are the highest of a
/// difference.
pub const FAR_BITS: u32 = 25;
/// Number of bits of a difference beside a far pointer.
pub const FAR_DELTA_BITS: u32 = 22;
/// Lowest bit of the difference in a short pointer, whose lower bits are a distance.
pub const SHORT_BITS: u32 = 8;

/// The part of the quadtree that contains a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnNode {
    /// A block of columns that all switch at this depth.
    Uniform(u32),
    /// A leaf.
    Leaf {
        /// The leaf's address.
        at: u32,
        /// The leaf's base.
        base: u32,
    },
}

/// A shape, or a root.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node {
    /// Its address; [`UNIFORM`] for a root all of whose columns switch at `base`.
    pub at: u32,
    /// Its base.
    pub base: u32,
    /// It spans 2^level columns along each side.
    pub level: u32,
}

/// Returns the number of half-words of the fields of a node's children that are in the mask `children`. The
/// other arguments are the node's first half-words.
pub(super) fn fields_length(low: u32, high: u32, kind: u32, children: u32) -> u32 {
    let short = high & !low & !kind;
    (low & children).count_ones() + 2 * (high & children).count_ones() - (short & children).count_ones()
}

/// Sign-extends a number of `bits` bits in two's complement to 32 bits.
fn signed(value: u32, bits: u32) -> u32 {
    let unused = 32 - bits;
    ((value << unused) as i32 >> unused) as u32
}

/// Words that contain shapes.
#[derive(Clone, Copy, Debug)]
pub struct Code<'c> {
    /// Half-words, two per word: the common section, then pages.
    pub words: &'c [u32],
}

impl<'c> Code<'c> {
    /// Returns the half-word at an address.
    pub fn half(self, at: u32) -> u32 {
        self.words[(at >> 1) as usize] >> (16 * (at & 1)) & 0xffff
    }

    /// Decodes child `child` of the node at `at`.
    pub fn child(self, at: u32, child: u32) -> Child<ShapeRef> {
        let [low, high, kind] = self.node_head(at);
        let field = at + 3 + fields_length(low, high, kind, (1 << child) - 1);
        self.child_at(at, field, [high >> child & 1, low >> child & 1, kind >> child & 1])
    }

    /// Decodes all children of the node at `at`, in order. Cheaper than one at a time.
    #[inline]
    pub fn children(self, at: u32) -> impl Iterator<Item = Child<ShapeRef>> {
        let [low, high, kind] = self.node_head(at);
        let mut field = at + 3;
        (0..16).map(move |child| {
            let form = [high >> child & 1, low >> child & 1, kind >> child & 1];
            let decoded = self.child_at(at, field, form);
            field += fields_length(form[1], form[0], form[2], 1);
            decoded
        })
    }

    fn node_head(self, at: u32) -> [u32; 3] {
        [0, 1, 2].map(|half| self.half(at + half))
    }

    /// Decodes a child of the node at `at` from its field. `form` has its bits of the node's second, first
    /// and third half-word.
    #[inline(always)]
    fn child_at(self, at: u32, field: u32, form: [u32; 3]) -> Child<ShapeRef> {
        let back = |distance: u32| ShapeRef::Here(at.wrapping_sub(distance));
        let near = |field: u32| match self.half(field) {
            half if half & NEAR == 0 => ShapeRef::Common(half),
            half => back(half & (NEAR - 1)),
        };
        match form {
            [0, 0, 0] => Child::Uniform(0),
            [0, 0, _] => Child::Never,
            [0, _, 0] => Child::Shape { shape: near(field), delta: 0 },
            [0, ..] => Child::Uniform(signed(self.half(field), 16)),
            [_, 0, 0] => {
                let short = self.half(field);
                Child::Shape { shape: back(short & 0xff), delta: signed(short >> SHORT_BITS, 8) }
            }
            [_, 0, _] => Child::Shape { shape: near(field + 1), delta: signed(self.half(field), 16) },
            _ => {
                let low = self.half(field);
                let far = self.half(field + 1) | self.half(field + 2) << 16;
                let delta = signed(low | (far & !FAR) >> FAR_BITS << 16, FAR_DELTA_BITS);
                let place = far & ((1 << FAR_BITS) - 1);
                match far & FAR {
                    0 => Child::Shape { shape: ShapeRef::Common(place), delta },
                    _ if place == 0 => Child::Uniform(delta),
                    _ => Child::Shape { shape: back(place), delta },
                }
            }
        }
    }

    /// Descends from a node to the block or leaf that contains a column. Returns it with its level.
    #[inline]
    pub fn descend(self, node: Node, column: [u32; 2]) -> (ColumnNode, u32) {
        self.descend_through(node, column, |_| ())
    }

    /// Does the same as [`Code::descend`], and calls `passed` with each node that has children.
    #[inline]
    pub fn descend_through(
        self,
        Node { mut at, mut base, mut level }: Node,
        [i, j]: [u32; 2],
        mut passed: impl FnMut(Node),
    ) -> (ColumnNode, u32) {
        if at == UNIFORM {
            return (ColumnNode::Uniform(base), level);
        }
        while level > LEAF_LEVEL {
            passed(Node { at, base, level });
            level -= NODE_LEVELS;
            match self.child(at, (j >> level & 3) << 2 | i >> level & 3) {
                Child::Never => return (ColumnNode::Uniform(NEVER), level),
                Child::Uniform(delta) => return (ColumnNode::Uniform(base.wrapping_add(delta)), level),
                Child::Shape { shape, delta } => {
                    at = shape.at();
                    base = base.wrapping_add(delta);
                }
            }
        }
        (ColumnNode::Leaf { at, base }, level)
    }

    /// Returns a reader of the leaf at `at`.
    #[inline]
    pub fn leaf(self, at: u32, base: u32) -> LeafCode<'c> {
        let head = LeafHead::new(self.half(at));
        let slant = if head.slanted { Slant::from_half(self.half(at + 1)) } else { Slant::default() };
        LeafCode { code: self, at, base, head, slant }
    }
}

/// A reader of one leaf.
#[derive(Clone, Copy)]
pub struct LeafCode<'c> {
    code: Code<'c>,
    at: u32,
    base: u32,
    head: LeafHead,
    slant: Slant,
}

impl LeafCode<'_> {
    fn difference(self, index: u32) -> u32 {
        self.head.difference(self.at, index, |at| self.code.half(at))
    }

    fn plane(self, p: u32) -> u64 {
        self.head.plane(self.at, p, |at| self.code.half(at))
    }

    /// Returns the last half-word of the differences if they do not fill it.
    pub fn padding(self) -> Option<u32> {
        let padded = self.head.width == 0 && self.head.differences() & 1 == 1;
        padded.then(|| self.code.half(self.at + self.head.planes_at() - 1))
    }

    /// Returns the depth at which a column switches. Depths saturate at 0 and at [`NEVER`].
    pub fn value(self, column: u32) -> u32 {
        let bit = |p| u32::from(self.plane(p) >> column & 1 == 1);
        let rank = (0..self.head.planes()).fold(0, |rank, p| rank | bit(p) << p);
        if rank > self.head.differences() {
            return NEVER;
        }
        let depth = (0..rank).fold(self.base, |depth, d| depth.saturating_add(self.difference(d)));
        depth.saturating_sub(self.slant.rise(column))
    }

    /// Returns bounds of the depths at which columns switch.
    pub fn bounds(self) -> [u32; 2] {
        let nearest = self.base.saturating_sub(self.slant.largest_rise());
        let deepest = |depth: u32, index| depth.saturating_add(self.difference(index));
        let farthest =
            if self.head.never { NEVER } else { (0..self.head.differences()).fold(self.base, deepest) };
        [nearest, farthest]
    }

    /// Whether columns of the last rank never switch.
    pub(crate) fn has_never(self) -> bool {
        self.head.never
    }

    /// Returns how far columns switch at most in front of the base, towards the sun, and at most behind it.
    /// Columns that never switch are not counted.
    pub(crate) fn reach(self) -> [i64; 2] {
        let differences = (0..self.head.differences()).map(|index| i64::from(self.difference(index)));
        [i64::from(self.slant.largest_rise()), differences.sum()]
    }

    /// Returns [`LeafCode::value`] of every column.
    pub fn values(self) -> [u32; 64] {
        let mut depths = [NEVER; 64];
        let mut depth = self.base;
        depths[0] = depth;
        for index in 0..self.head.differences() {
            depth = depth.saturating_add(self.difference(index));
            depths[index as usize + 1] = depth;
        }
        let ranks = self.head.ranks(self.at, |at| self.code.half(at));
        let rises = self.slant.rises();
        std::array::from_fn(|column| {
            let rank = u32::from(ranks[column]);
            if rank > self.head.differences() {
                return NEVER;
            }
            depths[rank as usize].saturating_sub(rises[column] as u32)
        })
    }

    /// Returns the columns of at least this rank. All 64 are compared at once, highest bit first.
    pub fn at_least(self, rank: u32) -> u64 {
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
