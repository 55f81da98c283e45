//! Shapes as a list, read from half-words, and written as half-words again.
//!
//! A shape has an index. Those of the common section come first, in the order in which they are stored. The
//! shapes of a bundle follow. The half-words of a page depend on its shapes alone, see [`Layout`].

use std::collections::HashMap;

use super::Fault;
use super::contour::Leaf;
pub(super) use crate::layout::depths::UNIFORM;
use crate::layout::depths::code::{self, Code, LeafHead};
use crate::layout::depths::page::{IN_PAGE, PAGE_LEVEL, Page};
use crate::layout::depths::write::{PlacedChild, ShapeRef, Writer};
use crate::layout::depths::{LEAF_LEVEL, NODE_LEVELS, ShapePlace};

/// Stands for the shape of a child if no column of the child switches.
pub(super) const NEVER_CHILD: u32 = u32::MAX - 1;
/// Number of levels that shapes can have.
pub(super) const LEVELS: usize = 4;

/// A child of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Child {
    /// Index of a shape, [`UNIFORM`] or [`NEVER_CHILD`].
    pub(super) shape: u32,
    /// Difference that is added to the base, wrapping. 0 for [`NEVER_CHILD`].
    pub(super) delta: u32,
}

impl Child {
    /// No column switches.
    pub(super) const NEVER: Self = Self { shape: NEVER_CHILD, delta: 0 };
    /// All columns switch at the base.
    const AT_BASE: Self = Self { shape: UNIFORM, delta: 0 };

    /// Whether the child is in a list of shapes, and takes half-words.
    #[inline(always)]
    pub(super) fn is_listed(self) -> bool {
        self != Self::NEVER && self != Self::AT_BASE
    }
}

/// A shape of a list.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// Where a leaf's half-words begin, or a node's listed children.
    first: u32,
    /// Children of a node, a bit each.
    ///
    /// | bits | meaning |
    /// |---|---|
    /// | 0 to 15 | child 0 to 15 is listed |
    /// | 16 to 31 | child 0 to 15 never switches |
    ///
    /// A child with neither bit switches at the node's base. `0xfffc_0001`: child 0 is listed, child 1
    /// switches at the base, and the others never switch.
    children: u32,
    level: u8,
}

/// A list of shapes. Each comes after the shapes that it points to.
///
/// Its memory is proportional to the half-words of its shapes, because only children that take at least one
/// half-word are listed.
#[derive(Debug, Default)]
pub(super) struct Shapes {
    entries: Vec<Entry>,
    leaf_halves: Vec<u16>,
    children: Vec<Child>,
    /// Indices of the shapes of each level.
    levels: [Vec<u32>; LEVELS],
}

/// Returns (level − 3) / 2.
pub(super) fn rank_of_level(level: u32) -> usize {
    ((level - LEAF_LEVEL) / NODE_LEVELS) as usize & 3
}

impl Shapes {
    /// Releases the memory that the lists do not use.
    pub(super) fn shrink_to_fit(&mut self) {
        self.entries.shrink_to_fit();
        self.leaf_halves.shrink_to_fit();
        self.children.shrink_to_fit();
        self.levels.iter_mut().for_each(Vec::shrink_to_fit);
    }

    /// Returns the bytes that the lists take.
    #[cfg(test)]
    pub(super) fn bytes(&self) -> usize {
        let indices: usize = self.levels.iter().map(Vec::capacity).sum();
        size_of::<Entry>() * self.entries.capacity()
            + size_of::<u16>() * self.leaf_halves.capacity()
            + size_of::<Child>() * self.children.capacity()
            + size_of::<u32>() * indices
    }

    /// Returns the number of shapes.
    pub(super) fn len(&self) -> u32 {
        self.entries.len() as u32
    }

    /// Returns the indices of the shapes of a level.
    pub(super) fn of_level(&self, level: u32) -> &[u32] {
        &self.levels[rank_of_level(level)]
    }

    /// Adds a leaf and returns its index. `before` is the number of shapes in lists before this one.
    #[inline]
    pub(super) fn push_leaf(&mut self, halves: &[u16], before: u32) -> u32 {
        let first = self.leaf_halves.len() as u32;
        self.leaf_halves.extend_from_slice(halves);
        self.push(Entry { first, children: 0, level: LEAF_LEVEL as u8 }, before)
    }

    /// Adds a node and returns its index. `before` is the number of shapes in lists before this one.
    pub(super) fn push_node(&mut self, level: u32, children: &[Child; 16], before: u32) -> u32 {
        let mut entry = Entry { first: self.children.len() as u32, children: 0, level: level as u8 };
        for (c, &child) in children.iter().enumerate() {
            match child {
                Child::NEVER => entry.children |= 1 << (16 + c),
                Child::AT_BASE => (),
                _ => {
                    entry.children |= 1 << c;
                    self.children.push(child);
                }
            }
        }
        self.push(entry, before)
    }

    #[inline]
    fn push(&mut self, entry: Entry, before: u32) -> u32 {
        let index = before + self.len();
        self.entries.push(entry);
        self.levels[rank_of_level(entry.level.into())].push(index);
        index
    }
}

/// The shapes of a part, while it is coded.
pub(super) enum Coded<'s> {
    /// The shapes coded so far.
    SoFar(Shapes),
    /// All shapes, for an encoder that codes them in order.
    All(&'s Shapes),
}

impl Coded<'_> {
    /// Returns the shapes.
    #[inline(always)]
    pub(super) fn shapes(&self) -> &Shapes {
        match self {
            Self::SoFar(shapes) => shapes,
            Self::All(shapes) => shapes,
        }
    }

    /// Records a coded shape and returns its index: `source` if all shapes are known, else the result of
    /// `push`, which adds the shape.
    #[inline(always)]
    pub(super) fn note(&mut self, source: u32, push: impl FnOnce(&mut Shapes) -> u32) -> u32 {
        match self {
            Self::SoFar(shapes) => push(shapes),
            Self::All(_) => source,
        }
    }
}

/// The shapes of a common section, and those of a bundle behind them.
#[derive(Clone, Copy)]
pub(super) struct Pool<'s> {
    pub(super) common: &'s Shapes,
    pub(super) own: &'s Shapes,
}

/// A shape.
pub(super) enum Shape<'s> {
    /// A leaf's half-words.
    Leaf(&'s [u16]),
    /// A node.
    Node(Node<'s>),
}

/// The children of a node.
#[derive(Clone, Copy)]
pub(super) struct Node<'s> {
    /// Bits of the children, as in an [`Entry`].
    children: u32,
    /// The listed children of the node, then those of later nodes.
    listed: &'s [Child],
}

impl Node<'_> {
    /// Returns child 0 to 15.
    #[inline(always)]
    pub(super) fn child(self, c: usize) -> Child {
        if self.children >> c & 1 == 1 {
            let before = self.children & 0xffff & ((1 << c) - 1);
            self.listed[before.count_ones() as usize]
        } else if self.children >> (16 + c) & 1 == 1 {
            Child::NEVER
        } else {
            Child::AT_BASE
        }
    }

    /// Returns all children.
    pub(super) fn all(self) -> [Child; 16] {
        std::array::from_fn(|c| self.child(c))
    }
}

impl<'s> Pool<'s> {
    #[inline(always)]
    fn find(self, shape: u32) -> (&'s Shapes, Entry) {
        let (list, index) = match shape.checked_sub(self.common.len()) {
            None => (self.common, shape),
            Some(own) => (self.own, own),
        };
        (list, list.entries[index as usize])
    }

    /// Returns the level of a shape.
    pub(super) fn level(self, shape: u32) -> u32 {
        self.find(shape).1.level.into()
    }

    /// Returns a shape.
    #[inline(always)]
    pub(super) fn get(self, shape: u32) -> Shape<'s> {
        let (list, entry) = self.find(shape);
        if u32::from(entry.level) == LEAF_LEVEL {
            let halves = &list.leaf_halves[entry.first as usize..];
            Shape::Leaf(&halves[..LeafHead::new(halves[0].into()).length() as usize])
        } else {
            let listed = &list.children[entry.first as usize..];
            Shape::Node(Node { children: entry.children, listed })
        }
    }
}

/// The shapes of a common section, for any number of bundles.
#[derive(Debug, Default)]
pub(crate) struct Common {
    pub(super) shapes: Shapes,
    /// Address of each shape.
    pub(super) addresses: Vec<u32>,
    /// Index of the shape at each place. Empty in a decoder.
    indices: HashMap<ShapePlace, u32>,
}

impl Common {
    /// Reads a valid common section. `places` are those of all its shapes, in order.
    ///
    /// # Errors
    /// Returns [`Fault`] if a writer would write other words for these shapes.
    pub(crate) fn new(words: &[u32], places: &[ShapePlace]) -> Result<Self, Fault> {
        let none = Self::default();
        let mut reader = Reader::new(&none, true);
        for &place in places {
            reader.shape(Code { words }, place)?;
        }
        let Reader { mut shapes, indices, .. } = reader;
        shapes.shrink_to_fit();
        let (mut common, written) = Self::lay_out(shapes, usize::MAX)?;
        if written != words || !common.addresses.iter().eq(places.iter().map(|place| &place.at)) {
            return Err(Fault);
        }
        common.indices = indices;
        Ok(common)
    }

    /// Writes shapes in the order of their indices. Returns them with the words.
    ///
    /// # Errors
    /// Returns [`Fault`] if there are more than `most_halves` half-words.
    pub(super) fn lay_out(shapes: Shapes, most_halves: usize) -> Result<(Self, Vec<u32>), Fault> {
        let none = Self::default();
        let pool = Pool { common: &none.shapes, own: &shapes };
        let mut layout = Layout::new(&none, pool, Writer::common(), most_halves);
        for index in 0..shapes.len() {
            layout.emit(index)?;
        }
        let (words, addresses) = (layout.writer.words(), layout.addresses);
        Ok((Self { shapes, addresses, indices: HashMap::new() }, words))
    }
}

/// Writes shapes as half-words. The shapes of a page are in post-order from the root, children in order, each
/// written once.
pub(super) struct Layout<'s> {
    common: &'s Common,
    pool: Pool<'s>,
    /// Number of half-words that may still be written.
    most_halves: usize,
    /// Address of each shape of this part that was written, else [`UNIFORM`].
    addresses: Vec<u32>,
    /// The shapes that were written, without those of the common section.
    written: Vec<u32>,
    writer: Writer,
}

impl<'s> Layout<'s> {
    fn new(common: &'s Common, pool: Pool<'s>, writer: Writer, most_halves: usize) -> Self {
        let addresses = vec![UNIFORM; pool.own.len() as usize];
        Self { common, pool, most_halves, addresses, written: Vec::new(), writer }
    }

    /// Begins the pages of a bundle. They may have up to `most_halves` half-words together.
    pub(super) fn of_pages(common: &'s Common, own: &'s Shapes, most_halves: usize) -> Self {
        Self::new(common, Pool { common: &common.shapes, own }, Writer::page(), most_halves)
    }

    /// Writes a page, and returns its root and its words.
    ///
    /// # Errors
    /// Returns [`Fault`] if the page is out of reach of pointers, or has too many half-words.
    pub(super) fn page(&mut self, root: u32) -> Result<(u32, Vec<u32>), Fault> {
        if root >= NEVER_CHILD {
            return Ok((UNIFORM, Vec::new()));
        }
        let root = match self.emit(root)? {
            ShapeRef::Common(at) => at,
            ShapeRef::Here(at) => at | IN_PAGE,
        };
        let words = std::mem::replace(&mut self.writer, Writer::page()).words();
        for own in self.written.drain(..) {
            self.addresses[own as usize] = UNIFORM;
        }
        self.most_halves = self.most_halves.checked_sub(2 * words.len()).ok_or(Fault)?;
        Ok((root, words))
    }

    /// Returns where a shape is. Its address is [`UNIFORM`] if it was not written.
    fn place(&self, shape: u32) -> ShapeRef {
        match shape.checked_sub(self.common.shapes.len()) {
            None => ShapeRef::Common(self.common.addresses[shape as usize]),
            Some(own) => ShapeRef::Here(self.addresses[own as usize]),
        }
    }

    /// Writes a shape after the shapes that it points to, unless it is already written.
    fn emit(&mut self, shape: u32) -> Result<ShapeRef, Fault> {
        let place = self.place(shape);
        if place != ShapeRef::Here(UNIFORM) {
            return Ok(place);
        }
        let at = match self.pool.get(shape) {
            Shape::Leaf(halves) => self.writer.leaf(halves),
            Shape::Node(node) => {
                let mut placed = [PlacedChild::Never; 16];
                for (placed, child) in placed.iter_mut().zip(node.all()) {
                    *placed = match child {
                        Child::NEVER => PlacedChild::Never,
                        Child { shape: UNIFORM, delta } => PlacedChild::Uniform(delta),
                        Child { shape, delta } => PlacedChild::Shape { delta, place: self.emit(shape)? },
                    };
                }
                self.writer.node(&placed).map_err(|_| Fault)?
            }
        };
        if self.writer.half_count() > self.most_halves {
            return Err(Fault);
        }
        let own = shape - self.common.shapes.len();
        self.addresses[own as usize] = at;
        self.written.push(own);
        Ok(ShapeRef::Here(at))
    }
}

/// Reads shapes from the half-words of valid pages, or of a valid common section. Equal shapes of pages are
/// listed once. Shapes of a common section are not merged.
pub(super) struct Reader<'c> {
    common: &'c Common,
    /// Whether this reads a common section.
    is_common: bool,
    /// The shapes that were read.
    pub(super) shapes: Shapes,
    /// Index of the shape at each place of the page.
    indices: HashMap<ShapePlace, u32>,
    leaves: HashMap<Vec<u16>, u32>,
    nodes: HashMap<(u32, [Child; 16]), u32>,
}

impl<'c> Reader<'c> {
    fn new(common: &'c Common, is_common: bool) -> Self {
        Self {
            common,
            is_common,
            shapes: Shapes::default(),
            indices: HashMap::new(),
            leaves: HashMap::new(),
            nodes: HashMap::new(),
        }
    }

    /// Begins to read the pages of a bundle.
    pub(super) fn of_pages(common: &'c Common) -> Self {
        Self::new(common, false)
    }

    /// Reads a page. Returns its root as a child.
    pub(super) fn page(&mut self, page: &Page<'_>) -> Result<Child, Fault> {
        self.indices.clear();
        let delta = page.base;
        let shape = match page.root {
            UNIFORM if *page == Page::OUTSIDE => return Ok(Child::NEVER),
            UNIFORM => UNIFORM,
            root if root & IN_PAGE != 0 => {
                let place = ShapePlace { at: root & !IN_PAGE, level: PAGE_LEVEL };
                self.shape(Code { words: page.words }, place)?
            }
            at => self.of_common(ShapePlace { at, level: PAGE_LEVEL })?,
        };
        Ok(Child { shape, delta })
    }

    fn of_common(&self, place: ShapePlace) -> Result<u32, Fault> {
        self.common.indices.get(&place).copied().ok_or(Fault)
    }

    /// Reads a shape, and the shapes that it points to. Returns its index.
    fn shape(&mut self, code: Code<'_>, place: ShapePlace) -> Result<u32, Fault> {
        if let Some(&known) = self.indices.get(&place) {
            return Ok(known);
        }
        let index =
            if place.level == LEAF_LEVEL { self.leaf(code, place.at)? } else { self.node(code, place)? };
        self.indices.insert(place, index);
        Ok(index)
    }

    fn leaf(&mut self, code: Code<'_>, at: u32) -> Result<u32, Fault> {
        let length = LeafHead::new(code.half(at)).length();
        let halves: Vec<u16> = (at..at + length).map(|at| code.half(at) as u16).collect();
        if let Some(&known) = self.leaves.get(&halves) {
            return Ok(known);
        }
        Leaf::read(&halves).ok_or(Fault)?;
        let index = self.shapes.push_leaf(&halves, self.common.shapes.len());
        if !self.is_common {
            self.leaves.insert(halves, index);
        }
        Ok(index)
    }

    fn node(&mut self, code: Code<'_>, ShapePlace { at, level }: ShapePlace) -> Result<u32, Fault> {
        let mut children = [Child::NEVER; 16];
        for (child, decoded) in children.iter_mut().zip(code.children(at)) {
            *child = match decoded {
                code::Child::Never => Child::NEVER,
                code::Child::Uniform(delta) => Child { shape: UNIFORM, delta },
                code::Child::Shape { at, delta, is_relative } => {
                    let place = ShapePlace { at, level: level - NODE_LEVELS };
                    let here = is_relative || self.is_common;
                    let shape = if here { self.shape(code, place)? } else { self.of_common(place)? };
                    Child { shape, delta }
                }
            };
        }
        let before = self.common.shapes.len();
        if self.is_common {
            return Ok(self.shapes.push_node(level, &children, before));
        }
        let next = before + self.shapes.len();
        let index = *self.nodes.entry((level, children)).or_insert(next);
        if index == next {
            self.shapes.push_node(level, &children, before);
        }
        Ok(index)
    }
}
