//! Shapes while a hierarchy grows: each kept once, or, for the plain form, each kept by itself. Their units may be paged out.

use std::sync::Arc;

use hashbrown::HashTable;

use super::UNIFORM;
use super::code::LeafHead;
use crate::dag::store::mix;
use crate::paged::{PagedVec, Spill, Word};

/// State of a node's child, two bits in its first word: switches at the base, never, a shape with the same base, one with its own.
pub(super) const INHERITS: u32 = 0;
pub(super) const NEVER: u32 = 1;
pub(super) const SHARES: u32 = 2;
pub(super) const OWN: u32 = 3;

/// Units that no shape has more of, whatever its first says.
const MOST_UNITS: usize = 288;

/// Something that shapes are lists of.
pub(super) trait Unit: Word {
    /// Units of the shape that begins with this one.
    fn length(self) -> usize;
    fn bits(self) -> u64;
}

/// Half-words of a leaf.
impl Unit for u16 {
    fn length(self) -> usize {
        LeafHead::new(self.into()).length() as usize
    }

    fn bits(self) -> u64 {
        self.into()
    }
}

/// Words of a node: states, then an index for each [`SHARES`], a difference and an index for each [`OWN`].
impl Unit for u32 {
    fn length(self) -> usize {
        let shapes = self >> 1 & 0x5555_5555;
        let own = self & shapes;
        1 + (shapes.count_ones() + own.count_ones()) as usize
    }

    fn bits(self) -> u64 {
        self.into()
    }
}

/// Shapes of one level.
pub(super) struct Arena<T> {
    units: PagedVec<T>,
    /// Where each shape begins.
    offsets: Vec<u32>,
    table: HashTable<u32>,
    spill: Option<Arc<Spill>>,
}

impl<T: Unit> Arena<T> {
    fn new(spill: Option<&Arc<Spill>>) -> Self {
        Self {
            units: PagedVec::new(spill),
            offsets: Vec::new(),
            table: HashTable::new(),
            spill: spill.cloned(),
        }
    }

    /// Has `f` look at a shape's units.
    pub(super) fn with<R>(&self, index: u32, f: impl FnOnce(&[T]) -> R) -> R {
        shape(&self.units, &self.offsets, index, f)
    }

    /// How many shapes there are.
    pub(super) fn len(&self) -> usize {
        self.offsets.len()
    }

    /// The index of a shape; where `merged`, of the one that is equal.
    pub(super) fn intern(&mut self, content: &[T], merged: bool) -> u32 {
        let next = self.offsets.len() as u32;
        let mut index = next;
        if merged {
            if self.table.len() == self.table.capacity() {
                self.grow();
            }
            let Self { units, offsets, table, .. } = self;
            let same = |i: &u32| shape(units, offsets, *i, |found| found == content);
            let entry = table.entry(hash(content), same, |i| shape(units, offsets, *i, hash));
            index = *entry.or_insert(next).get();
        }
        if index == next {
            self.offsets.push(self.units.len() as u32);
            self.units.extend_from_slice(content);
        }
        index
    }

    /// A table twice as large, made anew by one walk along the shapes; the full one is gone before.
    fn grow(&mut self) {
        let (capacity, before) = (self.table.capacity(), self.table.allocation_size());
        self.table = HashTable::new();
        let mut table = HashTable::with_capacity((2 * capacity).max(LEAST_CAPACITY));
        if let Some(spill) = &self.spill {
            spill.give_up(table.allocation_size().saturating_sub(before) as u64);
        }
        for i in 0..self.len() as u32 {
            table.insert_unique(self.with(i, hash), i, |i| self.with(*i, hash));
        }
        self.table = table;
    }

    /// Nothing more will be taken in.
    fn seal(&mut self) {
        self.table = HashTable::new();
        self.units.shrink_to_fit();
    }

    fn memory_bytes(&self) -> u64 {
        (self.units.memory_bytes() + 4 * self.offsets.capacity() + self.table.allocation_size()) as u64
    }
}

fn shape<T: Unit, R>(units: &PagedVec<T>, offsets: &[u32], index: u32, f: impl FnOnce(&[T]) -> R) -> R {
    units.with::<MOST_UNITS, R>(offsets[index as usize] as usize, T::length, f)
}

/// Entries that the smallest table has room for.
const LEAST_CAPACITY: usize = 14;

fn hash<T: Unit>(content: &[T]) -> u64 {
    content.iter().fold(content.len() as u64, |h, u| mix(h ^ u.bits()))
}

/// Leaves, and nodes of levels 5, 7 and 9. Indices of a node's children are those of the level two below.
pub(super) struct ShapeStore {
    pub(super) leaves: Arena<u16>,
    pub(super) nodes: [Arena<u32>; 3],
}

impl ShapeStore {
    pub(super) fn new(spill: Option<&Arc<Spill>>) -> Self {
        Self { leaves: Arena::new(spill), nodes: std::array::from_fn(|_| Arena::new(spill)) }
    }

    /// How many shapes there are.
    pub(super) fn shapes(&self) -> usize {
        self.leaves.len() + self.nodes.iter().map(Arena::len).sum::<usize>()
    }

    /// Units of all shapes, in half-words.
    pub(super) fn halves(&self) -> usize {
        self.leaves.units.len() + 2 * self.nodes.iter().map(|arena| arena.units.len()).sum::<usize>()
    }

    /// Nothing more will be taken in: what that needs is freed.
    pub(super) fn seal(&mut self) {
        self.leaves.seal();
        self.nodes.iter_mut().for_each(Arena::seal);
    }

    /// Bytes held beside what is paged.
    pub(super) fn memory_bytes(&self) -> u64 {
        self.leaves.memory_bytes() + self.nodes.iter().map(Arena::memory_bytes).sum::<u64>()
    }
}

/// One entry of a node as the store keeps it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Entry {
    pub(super) state: u32,
    /// What its base has more, wrapping.
    pub(super) delta: u32,
    /// The child shape's index; [`UNIFORM`] where there is none.
    pub(super) index: u32,
}

/// The sixteen entries of a node's words.
pub(super) fn entries(words: &[u32]) -> impl Iterator<Item = Entry> + '_ {
    let mut at = 1;
    let mut take = move || {
        at += 1;
        words[at - 1]
    };
    (0..16).map(move |c| {
        let state = words[0] >> (2 * c) & 3;
        let delta = if state == OWN { take() } else { 0 };
        let index = if state == SHARES || state == OWN { take() } else { UNIFORM };
        Entry { state, delta, index }
    })
}
