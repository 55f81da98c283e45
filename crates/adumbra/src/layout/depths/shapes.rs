//! Shapes as a list: read from half-words, and made unique. The coder, and the packer and linker of a bake,
//! use this list.

use std::collections::HashMap;
use std::hash::BuildHasher;

use hashbrown::{DefaultHashBuilder, HashTable};

use crate::layout::depths::child::{Child, Children, ShapePlace, ShapeRef};
use crate::layout::depths::code::Code;
use crate::layout::depths::leaf::LeafHead;
use crate::layout::depths::{LEAF_LEVEL, NODE_LEVELS, UNIFORM};

/// A shape of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shape<'s> {
    /// A leaf's half-words.
    Leaf(&'s [u16]),
    /// A node.
    Node(ListedNode<'s>),
}

/// A node of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ListedNode<'s> {
    level: u8,
    /// See [`Entry::children`].
    children: u32,
    listed: &'s [Listed],
}

impl ListedNode<'_> {
    /// Returns the level.
    pub fn level(self) -> u32 {
        self.level.into()
    }

    /// Returns child 0 to 15.
    #[inline(always)]
    pub fn child(self, c: usize) -> Child<u32> {
        if self.children >> c & 1 == 1 {
            let before = self.children & 0xffff & ((1 << c) - 1);
            self.listed[before.count_ones() as usize].child()
        } else if self.children >> (16 + c) & 1 == 1 {
            Child::Never
        } else {
            Child::Uniform(0)
        }
    }

    /// Returns all children. Cheaper than one at a time.
    pub fn all(self) -> Children<u32> {
        let mut listed = self.listed.iter();
        std::array::from_fn(|c| match (self.children >> c & 1, self.children >> (16 + c) & 1) {
            (0, 0) => Child::Uniform(0),
            (0, _) => Child::Never,
            _ => listed.next().map_or(Child::Never, |child| child.child()),
        })
    }
}

/// A child that is listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Listed {
    /// Index of a shape, or [`UNIFORM`].
    shape: u32,
    delta: u32,
}

impl Listed {
    #[inline(always)]
    fn child(self) -> Child<u32> {
        match self {
            Self { shape: UNIFORM, delta } => Child::Uniform(delta),
            Self { shape, delta } => Child::Shape { shape, delta },
        }
    }
}

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
pub struct ShapeList {
    entries: Vec<Entry>,
    leaf_halves: Vec<u16>,
    listed: Vec<Listed>,
    /// Indices of the shapes of each level.
    levels: [Vec<u32>; LEVELS],
}

/// Number of levels that shapes can have.
pub(crate) const LEVELS: usize = 4;

/// Returns (level − 3) / 2.
pub(crate) fn rank_of_level(level: u32) -> usize {
    ((level - LEAF_LEVEL) / NODE_LEVELS) as usize & 3
}

impl ShapeList {
    /// Removes all shapes.
    pub fn clear(&mut self) {
        self.entries.clear();
        self.leaf_halves.clear();
        self.listed.clear();
        self.levels.iter_mut().for_each(Vec::clear);
    }

    /// Releases the memory that the list does not use.
    pub(crate) fn shrink_to_fit(&mut self) {
        self.entries.shrink_to_fit();
        self.leaf_halves.shrink_to_fit();
        self.listed.shrink_to_fit();
        self.levels.iter_mut().for_each(Vec::shrink_to_fit);
    }

    /// Returns the bytes that the list takes.
    #[cfg(test)]
    pub(crate) fn bytes(&self) -> usize {
        size_of::<Entry>() * self.entries.capacity()
            + size_of::<u16>() * self.leaf_halves.capacity()
            + size_of::<Listed>() * self.listed.capacity()
            + size_of::<u32>() * self.levels.iter().map(Vec::capacity).sum::<usize>()
    }

    /// Returns the number of shapes.
    pub fn len(&self) -> u32 {
        self.entries.len() as u32
    }

    /// Whether there are no shapes.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Returns the level of a shape.
    pub fn level(&self, shape: u32) -> u32 {
        self.entries[shape as usize].level.into()
    }

    /// Returns the indices of the shapes of a level, ascending.
    pub(crate) fn of_level(&self, level: u32) -> &[u32] {
        &self.levels[rank_of_level(level)]
    }

    /// Returns a shape.
    #[inline(always)]
    pub fn get(&self, shape: u32) -> Shape<'_> {
        let Entry { first, children, level } = self.entries[shape as usize];
        if u32::from(level) == LEAF_LEVEL {
            let halves = &self.leaf_halves[first as usize..];
            Shape::Leaf(&halves[..LeafHead::new(halves[0].into()).length() as usize])
        } else {
            let count = (children & 0xffff).count_ones() as usize;
            Shape::Node(ListedNode { level, children, listed: &self.listed[first as usize..][..count] })
        }
    }

    /// Adds a leaf and returns its index.
    #[inline]
    pub fn push_leaf(&mut self, halves: impl IntoIterator<Item = u16>) -> u32 {
        let first = self.leaf_halves.len() as u32;
        self.leaf_halves.extend(halves);
        self.push(Entry { first, children: 0, level: LEAF_LEVEL as u8 })
    }

    /// Adds a node and returns its index. The list does not look at the numbers of shapes, which may be those
    /// of another list, but [`UNIFORM`] must not be one.
    pub fn push_node(&mut self, level: u32, children: &Children<u32>) -> u32 {
        let mut entry = Entry { first: self.listed.len() as u32, children: 0, level: level as u8 };
        for (c, &child) in children.iter().enumerate() {
            let listed = match child {
                Child::Never => {
                    entry.children |= 1 << (16 + c);
                    continue;
                }
                Child::Uniform(0) => continue,
                Child::Uniform(delta) => Listed { shape: UNIFORM, delta },
                Child::Shape { shape, delta } => Listed { shape, delta },
            };
            entry.children |= 1 << c;
            self.listed.push(listed);
        }
        self.push(entry)
    }

    #[inline]
    fn push(&mut self, entry: Entry) -> u32 {
        let index = self.len();
        self.entries.push(entry);
        self.levels[rank_of_level(entry.level.into())].push(index);
        index
    }

    /// Removes the last shape.
    fn pop(&mut self) {
        if let Some(Entry { first, level, .. }) = self.entries.pop() {
            self.levels[rank_of_level(level.into())].pop();
            if u32::from(level) == LEAF_LEVEL {
                self.leaf_halves.truncate(first as usize);
            } else {
                self.listed.truncate(first as usize);
            }
        }
    }
}

/// A list of shapes that can be merged, so that equal ones are listed once.
#[derive(Debug)]
pub struct ShapeSet {
    list: ShapeList,
    is_merged: bool,
    /// Indices of the shapes in the list, by content.
    table: HashTable<u32>,
    /// Seeded at random. The order of the list does not depend on it.
    hasher: DefaultHashBuilder,
}

impl ShapeSet {
    /// Creates an empty list. Without `is_merged`, equal shapes are listed again.
    pub fn new(is_merged: bool) -> Self {
        let (list, table) = (ShapeList::default(), HashTable::new());
        Self { list, is_merged, table, hasher: DefaultHashBuilder::default() }
    }

    /// Returns the shapes.
    pub fn list(&self) -> &ShapeList {
        &self.list
    }

    /// Returns the shapes.
    pub(crate) fn into_list(self) -> ShapeList {
        self.list
    }

    /// Removes all shapes.
    pub fn clear(&mut self) {
        self.list.clear();
        self.table.clear();
    }

    /// Returns the index of a leaf, which is added if it is new.
    pub fn leaf(&mut self, halves: &[u16]) -> u32 {
        let index = self.list.push_leaf(halves.iter().copied());
        self.once(index)
    }

    /// Returns the index of a node, which is added if it is new.
    pub fn node(&mut self, level: u32, children: &Children<u32>) -> u32 {
        let index = self.list.push_node(level, children);
        self.once(index)
    }

    /// Removes the last shape, `index`, if it is equal to an earlier one, and returns the index of that.
    fn once(&mut self, index: u32) -> u32 {
        if !self.is_merged {
            return index;
        }
        let Self { list, table, hasher, .. } = self;
        let hash = |index: &u32| hasher.hash_one(list.get(*index));
        let is_same = |&other: &u32| list.get(other) == list.get(index);
        let found = *table.entry(hash(&index), is_same, hash).or_insert(index).get();
        if found != index {
            list.pop();
        }
        found
    }
}

/// Reads the shapes of valid parts.
#[derive(Debug, Default)]
pub struct ShapeReader {
    /// For each half-word, one more than the index of the shape that was read there first.
    indices: Vec<u32>,
    /// Further shapes of a place: forged parts may have shapes of several levels there.
    others: HashMap<ShapePlace, u32>,
}

impl ShapeReader {
    /// Begins to read a part of `words` words.
    pub fn begin(&mut self, words: usize) {
        self.indices.clear();
        self.indices.resize(2 * words, 0);
        self.others.clear();
    }

    /// Adds the shape at a place to `list`, after the shapes that it points to, unless they have been read.
    /// Returns its index.
    ///
    /// The shapes of a common section are `common`, sorted, and their indices come before those of `list`.
    /// Without it, the part is a common section itself, or does not need one. Returns `None` if a pointer
    /// leads to another place of the common section.
    pub fn shape(
        &mut self,
        code: Code<'_>,
        place: ShapePlace,
        common: Option<&[ShapePlace]>,
        list: &mut ShapeList,
    ) -> Option<u32> {
        let ShapePlace { at, level } = place;
        let before = common.map_or(0, <[_]>::len) as u32;
        let first = self.indices[at as usize].checked_sub(1);
        let known = first.filter(|&first| list.level(first) == level);
        if let Some(known) = known.or_else(|| self.others.get(&place).copied()) {
            return Some(before + known);
        }
        let index = if level == LEAF_LEVEL {
            let length = LeafHead::new(code.half(at)).length();
            list.push_leaf((at..at + length).map(|at| code.half(at) as u16))
        } else {
            let mut children = [Child::Never; 16];
            for (child, decoded) in children.iter_mut().zip(code.children(at)) {
                let named = decoded.try_map(|shape| {
                    let place = ShapePlace { at: shape.at(), level: level - NODE_LEVELS };
                    match (shape, common) {
                        (ShapeRef::Common(_), Some(common)) => index_in(common, place).ok_or(()),
                        _ => self.shape(code, place, common, list).ok_or(()),
                    }
                });
                *child = named.ok()?;
            }
            list.push_node(level, &children)
        };
        match self.indices[at as usize] {
            0 => self.indices[at as usize] = index + 1,
            _ => _ = self.others.insert(place, index),
        }
        Some(before + index)
    }
}

/// Returns the index of a place among sorted ones.
pub(crate) fn index_in(places: &[ShapePlace], place: ShapePlace) -> Option<u32> {
    places.binary_search(&place).ok().map(|index| index as u32)
}
