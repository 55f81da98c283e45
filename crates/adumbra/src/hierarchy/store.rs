//! Shapes while a hierarchy grows: each kept once, or, for the plain form, each kept by itself.

use hashbrown::HashTable;

use super::UNIFORM;
use super::code::LeafHead;
use crate::dag::store::mix;

/// State of a node's child, two bits in its first word: switches at the base, never, a shape with the same base, one with its own.
pub(super) const INHERITS: u32 = 0;
pub(super) const NEVER: u32 = 1;
pub(super) const SHARES: u32 = 2;
pub(super) const OWN: u32 = 3;

/// Something that shapes are lists of.
pub(super) trait Unit: Copy + Eq {
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
#[derive(Default)]
pub(super) struct Arena<T> {
    units: Vec<T>,
    /// Where each shape begins.
    offsets: Vec<u32>,
    table: HashTable<u32>,
}

impl<T: Unit> Arena<T> {
    /// A shape's units.
    pub(super) fn get(&self, index: u32) -> &[T] {
        shape(&self.units, self.offsets[index as usize])
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
            let (units, offsets) = (&self.units, &self.offsets);
            let get = |i: &u32| shape(units, offsets[*i as usize]);
            let hash = |content: &[T]| content.iter().fold(content.len() as u64, |h, u| mix(h ^ u.bits()));
            let found = self.table.entry(hash(content), |i| get(i) == content, |i| hash(get(i)));
            index = *found.or_insert(next).get();
        }
        if index == next {
            self.offsets.push(self.units.len() as u32);
            self.units.extend_from_slice(content);
        }
        index
    }

    /// Nothing more will be taken in.
    fn seal(&mut self) {
        self.table = HashTable::new();
        self.units.shrink_to_fit();
    }

    fn memory_bytes(&self) -> u64 {
        let units = self.units.capacity() * size_of::<T>();
        (units + 4 * self.offsets.capacity() + 5 * self.table.capacity()) as u64
    }
}

fn shape<T: Unit>(units: &[T], offset: u32) -> &[T] {
    let from = offset as usize;
    &units[from..from + units[from].length()]
}

/// Leaves, and nodes of levels 5, 7 and 9. Indices of a node's children are those of the level two below.
#[derive(Default)]
pub(super) struct ShapeStore {
    pub(super) leaves: Arena<u16>,
    pub(super) nodes: [Arena<u32>; 3],
}

impl ShapeStore {
    /// Nothing more will be taken in: what that needs is freed.
    pub(super) fn seal(&mut self) {
        self.leaves.seal();
        self.nodes.iter_mut().for_each(Arena::seal);
    }

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
