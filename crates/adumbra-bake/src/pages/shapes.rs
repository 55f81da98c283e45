//! The shapes of a page as a list: drafted from blocks whose depths have been chosen, or read from the page's
//! words.
//!
//! Shapes are in order of last visit: children come before their parents, and the root is last.

use adumbra::layout::depths::code::{self, Code, LeafHead};
use adumbra::layout::depths::page::PAGE_LEVEL;
use adumbra::layout::depths::write::{OutOfReach, PlacedChild, ShapeRef, Writer};
use adumbra::layout::depths::{LEAF_LEVEL, NODE_LEVELS};
use adumbra_scene::random::mix;
use hashbrown::HashTable;
use xxhash_rust::xxh3::xxh3_128;

/// A child of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Child {
    /// All columns switch at the base plus this difference.
    Uniform(u32),
    /// No column switches.
    Never,
    /// A shape, by its index in the list.
    Shape {
        /// Difference between the shape's base and the node's, wrapping.
        delta: u32,
        index: u32,
    },
}

/// The children of a node, in the order `y·4 + x`.
pub(crate) type Children = [Child; 16];

/// A shape of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// A leaf: where its half-words are.
    Leaf { first: u32, length: u32 },
    /// A node: its level, and the index of its children.
    Node { level: u8, children: u32 },
}

impl Shape {
    pub(super) fn level(self) -> u32 {
        match self {
            Self::Leaf { .. } => LEAF_LEVEL,
            Self::Node { level, .. } => level.into(),
        }
    }
}

/// The shapes of a page.
#[derive(Debug, Default)]
pub(crate) struct Shapes {
    pub(super) list: Vec<Shape>,
    leaf_halves: Vec<u16>,
    nodes: Vec<Children>,
}

impl Shapes {
    pub(super) fn clear(&mut self) {
        self.list.clear();
        self.leaf_halves.clear();
        self.nodes.clear();
    }

    pub(super) fn leaf(&self, first: u32, length: u32) -> &[u16] {
        &self.leaf_halves[first as usize..][..length as usize]
    }

    pub(super) fn children(&self, index: u32) -> &Children {
        &self.nodes[index as usize]
    }

    /// Writes those shapes of a page that are not in the common section, in order, and sets the places of
    /// all. `in_common` returns the address of a shape of the list there.
    pub(super) fn write(
        &self,
        in_common: impl Fn(usize) -> Option<u32>,
        places: &mut Vec<ShapeRef>,
    ) -> Result<Vec<u32>, OutOfReach> {
        places.clear();
        let mut writer = Writer::page();
        for (index, shape) in self.list.iter().enumerate() {
            let place = match (in_common(index), *shape) {
                (Some(at), _) => ShapeRef::Common(at),
                (None, Shape::Leaf { first, length }) => {
                    ShapeRef::Here(writer.leaf(self.leaf(first, length)))
                }
                (None, Shape::Node { children, .. }) => ShapeRef::Here(
                    writer.node(&placed(self.children(children), |child| places[child as usize]))?,
                ),
            };
            places.push(place);
        }
        Ok(writer.words())
    }

    fn push_leaf(&mut self, halves: impl IntoIterator<Item = u16>) -> u32 {
        let first = self.leaf_halves.len() as u32;
        self.leaf_halves.extend(halves);
        self.list.push(Shape::Leaf { first, length: self.leaf_halves.len() as u32 - first });
        self.list.len() as u32 - 1
    }

    fn push_node(&mut self, children: Children, level: u32) -> u32 {
        self.nodes.push(children);
        self.list.push(Shape::Node { level: level as u8, children: self.nodes.len() as u32 - 1 });
        self.list.len() as u32 - 1
    }
}

/// Returns children with the places of their shapes.
pub(super) fn placed(children: &Children, mut place_of: impl FnMut(u32) -> ShapeRef) -> [PlacedChild; 16] {
    children.map(|child| match child {
        Child::Never => PlacedChild::Never,
        Child::Uniform(delta) => PlacedChild::Uniform(delta),
        Child::Shape { delta, index } => PlacedChild::Shape { delta, place: place_of(index) },
    })
}

/// Collects the shapes of a page from the leaves up.
#[derive(Debug, Default)]
pub(crate) struct Draft {
    pub(super) shapes: Shapes,
    /// Indices of the shapes in the list, by content.
    table: HashTable<u32>,
}

impl Draft {
    /// Begins another page.
    pub(crate) fn clear(&mut self) {
        self.shapes.clear();
        self.table.clear();
    }

    /// Returns the index of a leaf with these half-words. `merged`: if there is one already, it is used
    /// again.
    pub(crate) fn leaf(&mut self, halves: &[u16], merged: bool) -> u32 {
        let is_same = |shapes: &Shapes, index: u32| match shapes.list[index as usize] {
            Shape::Leaf { first, length } => shapes.leaf(first, length) == halves,
            Shape::Node { .. } => false,
        };
        let add = |shapes: &mut Shapes| shapes.push_leaf(halves.iter().copied());
        self.shape(hash_of_leaf(halves), merged, is_same, add)
    }

    /// Returns the index of a node with these children. See [`Draft::leaf`].
    pub(crate) fn node(&mut self, children: &Children, level: u32, merged: bool) -> u32 {
        let is_same = |shapes: &Shapes, index: u32| match shapes.list[index as usize] {
            shape @ Shape::Node { children: found, .. } => {
                shape.level() == level && shapes.children(found) == children
            }
            Shape::Leaf { .. } => false,
        };
        let add = |shapes: &mut Shapes| shapes.push_node(*children, level);
        self.shape(hash_of_node(children, level), merged, is_same, add)
    }

    /// Returns the words of the page whose root was drafted last, and the root's address.
    ///
    /// # Errors
    /// Returns [`OutOfReach`] if the page is too large.
    pub(crate) fn page(&self) -> Result<(Vec<u32>, u32), OutOfReach> {
        let mut places = Vec::new();
        let words = self.shapes.write(|_| None, &mut places)?;
        match places.last() {
            Some(ShapeRef::Here(at)) => Ok((words, *at)),
            Some(ShapeRef::Common(_)) | None => unreachable!("the root is in the page"),
        }
    }

    fn shape(
        &mut self,
        hash: u64,
        merged: bool,
        is_same: impl Fn(&Shapes, u32) -> bool,
        add: impl FnOnce(&mut Shapes) -> u32,
    ) -> u32 {
        let Self { shapes, table } = self;
        if !merged {
            return add(shapes);
        }
        let hash_of = |index: &u32| match shapes.list[*index as usize] {
            Shape::Leaf { first, length } => hash_of_leaf(shapes.leaf(first, length)),
            shape @ Shape::Node { children, .. } => hash_of_node(shapes.children(children), shape.level()),
        };
        let next = shapes.list.len() as u32;
        let found = *table.entry(hash, |&index| is_same(shapes, index), hash_of).or_insert(next).get();
        if found == next { add(shapes) } else { found }
    }
}

fn hash_of_leaf(halves: &[u16]) -> u64 {
    halves.chunks(4).fold(halves.len() as u64, |hash, four| {
        mix(hash ^ four.iter().fold(0, |word, &half| word << 16 | u64::from(half)))
    })
}

fn hash_of_node(children: &Children, level: u32) -> u64 {
    children.iter().fold(level.into(), |hash, child| {
        mix(hash
            ^ match *child {
                Child::Never => u64::MAX,
                Child::Uniform(delta) => u64::from(delta),
                Child::Shape { delta, index } => u64::from(index + 1) << 32 | u64::from(delta),
            })
    })
}

/// Reads the shapes of pages, and hashes them: equal shapes have equal hashes in every page.
#[derive(Debug, Default)]
pub(crate) struct Reader {
    shapes: Shapes,
    /// The hash of each shape of the list, from its level and all that is below it.
    pub(super) hashes: Vec<u128>,
    /// The level of each shape of the list.
    pub(super) levels: Vec<u8>,
    /// For each half-word of the page, one more than the index of the shape that was last read there. Forged
    /// pages may have shapes of several levels in one place.
    places: Vec<u32>,
    hashed: Vec<u8>,
}

impl Reader {
    /// Reads a page without a common section, from its words and the address of its root. A shape that is
    /// stored once is listed once.
    pub(crate) fn read(&mut self, words: &[u32], root: u32) {
        self.shapes.clear();
        self.walk::<true>(words, root);
    }

    /// Hashes the shapes of a page as [`Reader::read`] does, but does not list the shapes themselves.
    pub(super) fn read_hashes(&mut self, words: &[u32], root: u32) {
        self.walk::<false>(words, root);
    }

    fn walk<const LISTS: bool>(&mut self, words: &[u32], root: u32) {
        self.hashes.clear();
        self.levels.clear();
        self.places.clear();
        self.places.resize(2 * words.len(), 0);
        self.shape::<LISTS>(Code { words }, root, PAGE_LEVEL);
    }

    pub(super) fn shapes(&self) -> &Shapes {
        &self.shapes
    }

    fn shape<const LISTS: bool>(&mut self, code: Code<'_>, at: u32, level: u32) -> u32 {
        if let Some(known) = self.places[at as usize].checked_sub(1)
            && u32::from(self.levels[known as usize]) == level
        {
            return known;
        }
        if level == LEAF_LEVEL {
            self.leaf::<LISTS>(code, at);
        } else {
            let mut children = [Child::Never; 16];
            for (child, decoded) in children.iter_mut().zip(code.children(at)) {
                *child = match decoded {
                    code::Child::Never => Child::Never,
                    code::Child::Uniform(delta) => Child::Uniform(delta),
                    code::Child::Shape { at, delta, .. } => {
                        Child::Shape { delta, index: self.shape::<LISTS>(code, at, level - NODE_LEVELS) }
                    }
                };
            }
            self.node::<LISTS>(&children, level);
        }
        let count = self.hashes.len() as u32;
        self.places[at as usize] = count;
        count - 1
    }

    fn leaf<const LISTS: bool>(&mut self, code: Code<'_>, at: u32) {
        let length = LeafHead::new(code.half(at)).length();
        self.hashed.clear();
        let halves = (at..at + length).map(|at| code.half(at) as u16);
        let hashed = &mut self.hashed;
        let halves = halves.inspect(|half| hashed.extend_from_slice(&half.to_le_bytes()));
        if LISTS {
            self.shapes.push_leaf(halves);
        } else {
            halves.for_each(drop);
        }
        self.add_hash(LEAF_LEVEL);
    }

    fn node<const LISTS: bool>(&mut self, children: &Children, level: u32) {
        let hashed = &mut self.hashed;
        hashed.clear();
        for child in children {
            match *child {
                Child::Never => hashed.push(0),
                Child::Uniform(delta) => {
                    hashed.push(1);
                    hashed.extend_from_slice(&delta.to_le_bytes());
                }
                Child::Shape { delta, index } => {
                    hashed.push(2);
                    hashed.extend_from_slice(&delta.to_le_bytes());
                    hashed.extend_from_slice(&self.hashes[index as usize].to_le_bytes());
                }
            }
        }
        self.add_hash(level);
        if LISTS {
            self.shapes.push_node(*children, level);
        }
    }

    fn add_hash(&mut self, level: u32) {
        self.levels.push(level as u8);
        self.hashed.push(level as u8);
        self.hashes.push(xxh3_128(&self.hashed));
    }
}
