//! The order in which shapes are coded, and the coding of everything except the inside of a leaf.
//!
//! Pages come in order, each from its root down. A shape is coded where it is first used, and is a reference
//! elsewhere. A common section is coded shape by shape, in the order in which they are stored. The same
//! functions serve both directions. An encoder passes the values to code; a decoder passes any values; both
//! get back the coded values.

use super::Fault;
use super::contour::{Leaf, Outline, class};
use super::edges::{Edges, Facing};
use super::model::Model;
use super::rans::Coder;
use super::shapes::{Coded, Pool};
use crate::layout::depths::child::Child;
use crate::layout::depths::leaf::MOST_HALVES;
use crate::layout::depths::page::{BUNDLE_PAGES, BUNDLE_SIDE, PAGE_LEVEL};
use crate::layout::depths::shapes::{LEVELS, Shape, ShapeList, rank_of_level};
use crate::layout::depths::slant::{SLANT_BITS, Slant};
use crate::layout::depths::{LEAF_LEVEL, NEVER, NODE_LEVELS, UNIFORM};

/// Number of shapes of a level that are remembered in order of their last use.
const RECENT: usize = 10;
/// Number of gradients that are remembered in order of their last use.
pub(super) const RECENT_SLANTS: usize = 13;

/// Symbols of a child's state. [`ABOVE`] and [`LEFT`] are the shapes of those blocks, [`SEEN`] any other
/// known one.
const UNIFORM_STATE: u32 = 0;
const NEVER_STATE: u32 = 1;
const NEW: u32 = 2;
const ABOVE: u32 = 3;
const LEFT: u32 = 4;
const SEEN: u32 = 5;

/// Symbols of a reference to a shape that is not a recent one.
const IN_COMMON: u32 = 14;
const IN_OWN: u32 = 15;

/// Codes shapes.
pub(super) struct Walk<'s, C> {
    pub(super) coder: C,
    pub(super) own: Coded<'s>,
    pub(super) model: Box<Model>,
    /// Shapes that both sides know.
    common: &'s ShapeList,
    /// The shapes that an encoder codes.
    source: Pool<'s>,
    /// Index of each own shape of the source among those that were coded, or [`UNIFORM`].
    coded: Vec<u32>,
    pub(super) edges: Edges,
    recent: [[u32; RECENT]; LEVELS],
    pub(super) recent_slants: [u16; RECENT_SLANTS],
    /// Number of half-words that may still be decoded.
    most_halves: usize,
    /// The last leaf, whose memory the next leaf reuses.
    scratch: Option<Box<Leaf>>,
}

impl<'s, C: Coder> Walk<'s, C> {
    /// Begins with shapes that both sides know. Decoding fails beyond `most_halves` half-words.
    pub(super) fn new(coder: C, common: &'s ShapeList, source: Pool<'s>, most_halves: usize) -> Self {
        Self {
            coder,
            own: Coded::SoFar(ShapeList::default()),
            model: Model::new(),
            common,
            source,
            coded: vec![UNIFORM; source.own.len() as usize],
            edges: Edges::new(),
            recent: [[UNIFORM; RECENT]; LEVELS],
            recent_slants: [0; RECENT_SLANTS],
            most_halves,
            scratch: None,
        }
    }

    /// Begins an encoder of a common section with these shapes.
    pub(super) fn of_section(coder: C, none: &'s ShapeList, shapes: &'s ShapeList) -> Self {
        let walk = Self::new(coder, none, Pool { common: none, own: shapes }, usize::MAX);
        Self { own: Coded::All(shapes), ..walk }
    }

    /// Codes the roots of pages, whose `delta` is the page's base. Each is a child whose parent has the base
    /// of the page before it.
    pub(super) fn pages(
        &mut self,
        sources: [Child<u32>; BUNDLE_PAGES],
    ) -> Result<[Child<u32>; BUNDLE_PAGES], Fault> {
        let mut roots = sources;
        let mut base = 0_u32;
        let side = BUNDLE_SIDE as usize;
        for (i, root) in roots.iter_mut().enumerate() {
            let at = [i % side, i / side].map(|c| c << PAGE_LEVEL);
            let source = root.moved(base.wrapping_neg());
            *root = self.child(PAGE_LEVEL, at, base, source)?.moved(base);
            if let Child::Uniform(delta) | Child::Shape { delta, .. } = *root {
                base = delta;
            }
        }
        Ok(roots)
    }

    /// Codes the number of shapes of a common section, and the shapes.
    pub(super) fn section(&mut self, count: u32) -> Result<(), Fault> {
        let count = self.model.count.code(&mut self.coder, count);
        for index in 0..count {
            let rank = if C::DECODES { 0 } else { rank_of_level(self.source.level(index)) as u32 };
            let rank = self.coder.symbol(&mut self.model.level, rank) & 3;
            let level = LEAF_LEVEL + NODE_LEVELS * rank;
            self.edges.forget([0, 0], level);
            if level == LEAF_LEVEL {
                self.leaf([0, 0], 0, index, 0)?;
            } else {
                self.node(level, [0, 0], 0, index)?;
            }
        }
        Ok(())
    }

    /// Codes a child. `base` is its parent's.
    fn child(
        &mut self,
        level: u32,
        at: [usize; 2],
        base: u32,
        source: Child<u32>,
    ) -> Result<Child<u32>, Fault> {
        let [above, left] = self.facing(level, at);
        let (source_shape, delta) = match source {
            Child::Never => (UNIFORM, 0),
            Child::Uniform(delta) => (UNIFORM, delta),
            Child::Shape { shape, delta } => (shape, delta),
        };
        let known = if C::DECODES { UNIFORM } else { self.known(source_shape) };
        let state = match source {
            Child::Uniform(_) => UNIFORM_STATE,
            Child::Never => NEVER_STATE,
            _ if known == UNIFORM => NEW,
            _ if known == above.shape => ABOVE,
            _ if known == left.shape => LEFT,
            _ => SEEN,
        };
        let rank = rank_of_level(level);
        let classes = usize::from(above.class) * class::COUNT + usize::from(left.class);
        let leaves = usize::from(above.kind != 0) + 2 * usize::from(left.kind != 0);
        let state = self.coder.symbol(&mut self.model.state[rank][leaves][classes], state);
        let target = base.wrapping_add(delta);
        let (shape, depth) = match state {
            NEVER_STATE => {
                self.edges.uniform(at, level, NEVER);
                return Ok(Child::Never);
            }
            UNIFORM_STATE => {
                let depth = self.plain_depth(level, at, base, true, target);
                self.edges.uniform(at, level, depth);
                return Ok(Child::Uniform(depth.wrapping_sub(base)));
            }
            NEW if level == LEAF_LEVEL => self.leaf(at, base, source_shape, target)?,
            NEW => {
                let depth = self.plain_depth(level, at, base, false, target);
                (self.node(level, at, depth, source_shape)?, depth)
            }
            ABOVE if above.shape != UNIFORM => self.seen(level, at, base, above.shape, target),
            LEFT if left.shape != UNIFORM => self.seen(level, at, base, left.shape, target),
            _ => {
                let shape = self.reference(level, known)?;
                self.seen(level, at, base, shape, target)
            }
        };
        to_front(&mut self.recent[rank], shape);
        Ok(Child::Shape { shape, delta: depth.wrapping_sub(base) })
    }

    /// Returns the neighbours above and to the left of a square. They have a shape only if the square is a
    /// leaf's.
    fn facing(&self, level: u32, [x, y]: [usize; 2]) -> [Facing; 2] {
        let [above, left] = [&self.edges.above[x >> LEAF_LEVEL..], &self.edges.left[y >> LEAF_LEVEL..]];
        if level == LEAF_LEVEL {
            return [above[0], left[0]];
        }
        let count = 1 << (level - LEAF_LEVEL);
        [above, left].map(|blocks| {
            let mut all = blocks[0];
            for block in &blocks[1..count] {
                all.class = if block.class == all.class { all.class } else { class::MIXED };
                all.kind |= block.kind;
            }
            Facing { shape: UNIFORM, ..all }
        })
    }

    /// Returns the index of a shape of the source among those that were coded, or [`UNIFORM`].
    fn known(&self, shape: u32) -> u32 {
        match shape.checked_sub(self.source.common.len()) {
            _ if shape == UNIFORM => UNIFORM,
            None => shape,
            Some(own) => self.coded[own as usize],
        }
    }

    fn note(&mut self, source: u32, shape: u32) {
        if !C::DECODES {
            self.coded[(source - self.source.common.len()) as usize] = shape;
        }
    }

    /// Counts decoded half-words against the limit.
    fn spend(&mut self, halves: usize) -> Result<(), Fault> {
        self.most_halves = self.most_halves.checked_sub(halves).ok_or(Fault)?;
        Ok(())
    }

    /// Codes a reference to a shape: its place in the order of last use, or its number among the shapes of
    /// its level.
    fn reference(&mut self, level: u32, shape: u32) -> Result<u32, Fault> {
        let rank = rank_of_level(level);
        let way = if C::DECODES {
            0
        } else {
            let other = if shape < self.common.len() { IN_COMMON } else { IN_OWN };
            self.recent[rank].iter().position(|&r| r == shape).map_or(other, |place| place as u32)
        };
        let way = self.coder.symbol(&mut self.model.reference[rank], way);
        if way < IN_COMMON {
            return self.recent[rank].get(way as usize).copied().filter(|&s| s != UNIFORM).ok_or(Fault);
        }
        let before = self.common.len();
        let (shapes, first) = if way == IN_COMMON { (self.common, 0) } else { (self.own.shapes(), before) };
        let list = shapes.of_level(level);
        let number = if C::DECODES { 0 } else { list.binary_search(&(shape - first)).map_err(|_| Fault)? };
        let model = &mut self.model.number[rank][(way - IN_COMMON) as usize];
        let number = model.code(&mut self.coder, number as u32);
        list.get(number as usize).map(|index| first + index).ok_or(Fault)
    }

    /// Codes the base of a known shape. Returns the shape and its base.
    fn seen(&mut self, level: u32, at: [usize; 2], base: u32, shape: u32, target: u32) -> (u32, u32) {
        let pool = Pool { common: self.common, own: self.own.shapes() };
        if let Shape::Leaf(halves) = pool.get(shape) {
            let outline = Outline::of(halves);
            let depth = self.leaf_depth(at, base, outline.slant.into(), outline.kind, target);
            self.edges.leaf(at, depth, shape, &outline);
            return (shape, depth);
        }
        let depth = self.plain_depth(level, at, base, false, target);
        self.edges.shape(at, level, depth, shape, Pool { common: self.common, own: self.own.shapes() });
        (shape, depth)
    }

    /// Codes a new node. Returns its index.
    fn node(&mut self, level: u32, [x, y]: [usize; 2], base: u32, source: u32) -> Result<u32, Fault> {
        self.spend(3)?;
        let mut children = [Child::Never; 16];
        if !C::DECODES
            && let Shape::Node(node) = self.source.get(source)
        {
            children = node.all();
        }
        let below = level - NODE_LEVELS;
        for (c, child) in children.iter_mut().enumerate() {
            let at = [x + ((c & 3) << below), y + ((c >> 2) << below)];
            *child = self.child(below, at, base, *child)?;
            // A listed child takes at least one half-word.
            self.spend(usize::from(!matches!(child, Child::Never | Child::Uniform(0))))?;
        }
        let before = self.common.len();
        let index = self.own.note(source, |own| before + own.push_node(level, &children));
        self.note(source, index);
        Ok(index)
    }

    /// Codes a new leaf. `base` is its parent's, `target` its own. Returns its index and its own base.
    fn leaf(&mut self, at: [usize; 2], base: u32, source: u32, target: u32) -> Result<(u32, u32), Fault> {
        let mut leaf = self.scratch.take().unwrap_or_else(|| Box::new(Leaf::EMPTY));
        leaf.slant = 0;
        if !C::DECODES
            && let Shape::Leaf(halves) = self.source.get(source)
        {
            *leaf = Leaf::read(halves).ok_or(Fault)?;
        }
        self.head(at, &mut leaf)?;
        let depth = self.leaf_depth(at, base, leaf.slant, leaf.kind(), target);
        self.differences(at, depth, &mut leaf);
        self.columns(at, depth, &mut leaf);
        let mut buffer = [0; MOST_HALVES];
        let halves = leaf.halves(&mut buffer);
        self.spend(halves.len())?;
        let outline = Outline::of(halves);
        let before = self.common.len();
        let index = self.own.note(source, |own| before + own.push_leaf(halves.iter().copied()));
        self.edges.leaf(at, depth, index, &outline);
        self.note(source, index);
        self.scratch = Some(leaf);
        Ok((index, depth))
    }

    /// Codes the depth of a uniform child, or the base of a node.
    fn plain_depth(&mut self, level: u32, [x, y]: [usize; 2], base: u32, uniform: bool, depth: u32) -> u32 {
        let last = (1 << level) - 1;
        let [bottom, right] = [&self.edges.bottom, &self.edges.right];
        let known = [right[y], bottom[x], right[y + last], bottom[x + last], NEVER, base];
        let model = if uniform { &mut self.model.uniform } else { &mut self.model.node };
        model[rank_of_level(level)].code(&mut self.coder, known, depth)
    }

    /// Codes the base of a leaf.
    fn leaf_depth(&mut self, [x, y]: [usize; 2], base: u32, slant: u32, kind: u8, depth: u32) -> u32 {
        let plane = Slant::from_half(slant);
        let rise = |x, y| (plane.quarters(x, y) >> SLANT_BITS) as u32;
        let risen = |cell: u32, x, y| if cell == NEVER { NEVER } else { cell.wrapping_add(rise(x, y)) };
        let [bottom, right] = [&self.edges.bottom[x..x + 8], &self.edges.right[y..y + 8]];
        let [a, b] = [risen(right[0], -1, 0), risen(bottom[0], 0, -1)];
        let [c, d] = [risen(right[7], -1, 7), risen(bottom[7], 7, -1)];
        let known = [a.min(b).min(c).min(d), a, b, c, d, base];
        let model = usize::from(slant != 0) + 2 * usize::from(kind > 3);
        self.model.leaf[model].code(&mut self.coder, known, depth)
    }
}

/// Moves a value to the front, and keeps the order of the others. If the value is new, the last value is
/// dropped.
pub(super) fn to_front<T: Copy + PartialEq, const N: usize>(recent: &mut [T; N], value: T) {
    let place = recent.iter().position(|&r| r == value).unwrap_or(N - 1);
    recent.copy_within(..place, 1);
    recent[0] = value;
}
