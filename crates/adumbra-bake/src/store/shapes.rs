//! Storage of shapes while depths are built. Equal shapes are stored once, or, in the plain form, every shape
//! separately. Their units may be paged out.

use std::sync::Arc;

use hashbrown::HashTable;

use crate::store::paged::{PagedVec, Spill, Word};
use adumbra::layout::depths::UNIFORM;
use adumbra::layout::depths::code::LeafHead;
use adumbra_scene::random::mix;

/// State of a node's child, two bits in the node's first word: switches at the base, never switches, has a shape with
/// the same base, has a shape with its own base.
pub(crate) const INHERITS: u32 = 0;
pub(crate) const NEVER: u32 = 1;
pub(crate) const SHARES: u32 = 2;
pub(crate) const OWN: u32 = 3;

/// Upper bound on the number of units of a shape, whatever its first unit says.
const MAX_UNITS: usize = 288;

/// The element type of which shapes are made.
pub(crate) trait Unit: Word {
    /// Returns the number of units of the shape that begins with this one.
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

/// Words of a node: states, then an index for each [`SHARES`], and a difference and an index for each [`OWN`].
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
pub(crate) struct Arena<T> {
    units: PagedVec<T>,
    /// Offset of each shape's first unit.
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

    /// Calls `f` with a shape's units.
    pub(crate) fn with<R>(&self, index: u32, f: impl FnOnce(&[T]) -> R) -> R {
        shape(&self.units, &self.offsets, index, f)
    }

    /// Returns the number of shapes.
    pub(crate) fn len(&self) -> usize {
        self.offsets.len()
    }

    /// Returns the index of a shape. If `merged`, an equal shape that is already stored is reused.
    pub(crate) fn intern(&mut self, content: &[T], merged: bool) -> u32 {
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

    /// Replaces the table by one twice as large, refilled by a pass over the shapes. The full table is freed first.
    fn grow(&mut self) {
        let (capacity, before) = (self.table.capacity(), self.table.allocation_size());
        self.table = HashTable::new();
        let mut table = HashTable::with_capacity((2 * capacity).max(MIN_CAPACITY));
        if let Some(spill) = &self.spill {
            spill.give_up(table.allocation_size().saturating_sub(before) as u64);
        }
        for i in 0..self.len() as u32 {
            table.insert_unique(self.with(i, hash), i, |i| self.with(*i, hash));
        }
        self.table = table;
    }

    /// Frees what is needed only for adding shapes.
    fn seal(&mut self) {
        self.table = HashTable::new();
        self.units.shrink_to_fit();
    }

    fn memory_bytes(&self) -> u64 {
        (self.units.memory_bytes() + 4 * self.offsets.capacity() + self.table.allocation_size()) as u64
    }
}

fn shape<T: Unit, R>(units: &PagedVec<T>, offsets: &[u32], index: u32, f: impl FnOnce(&[T]) -> R) -> R {
    units.with::<MAX_UNITS, R>(offsets[index as usize] as usize, T::length, f)
}

/// Capacity of the smallest table.
const MIN_CAPACITY: usize = 14;

fn hash<T: Unit>(content: &[T]) -> u64 {
    content.iter().fold(content.len() as u64, |h, u| mix(h ^ u.bits()))
}

/// Leaves, and nodes of levels 5, 7 and 9. A node's child indices refer to the arena two levels below.
pub(crate) struct ShapeStore {
    pub(crate) leaves: Arena<u16>,
    pub(crate) nodes: [Arena<u32>; 3],
}

impl ShapeStore {
    pub(crate) fn new(spill: Option<&Arc<Spill>>) -> Self {
        Self { leaves: Arena::new(spill), nodes: std::array::from_fn(|_| Arena::new(spill)) }
    }

    /// Returns the total number of shapes.
    pub(crate) fn shapes(&self) -> usize {
        self.leaves.len() + self.nodes.iter().map(Arena::len).sum::<usize>()
    }

    /// Returns the size of all shapes in half-words.
    pub(crate) fn halves(&self) -> usize {
        self.leaves.units.len() + 2 * self.nodes.iter().map(|arena| arena.units.len()).sum::<usize>()
    }

    /// Frees what is needed only for adding shapes; none may be added afterwards.
    pub(crate) fn seal(&mut self) {
        self.leaves.seal();
        self.nodes.iter_mut().for_each(Arena::seal);
    }

    /// Bytes held apart from what is paged.
    pub(crate) fn memory_bytes(&self) -> u64 {
        self.leaves.memory_bytes() + self.nodes.iter().map(Arena::memory_bytes).sum::<u64>()
    }
}

/// One entry of a node in the store's format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    pub(crate) state: u32,
    /// Difference between the child's base and the node's, wrapping.
    pub(crate) delta: u32,
    /// The child shape's index, or [`UNIFORM`] if there is none.
    pub(crate) index: u32,
}

/// Decodes the sixteen entries of a node's words.
pub(crate) fn entries(words: &[u32]) -> impl Iterator<Item = Entry> + '_ {
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
