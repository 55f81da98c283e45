//! Hash-consing: every leaf mask and every node is stored once, and equal contents get equal references. Several
//! threads may store concurrently.
//!
//! Contents are compared in full before two nodes are merged; the hash only finds candidates. The hash also selects one
//! of 64 shards, each behind its own lock. References depend on the order of insertion; the contents and their number
//! do not. Contents may be paged out, but tables may not: a full table is dropped and rebuilt at twice the size by one
//! pass over the contents.
//!
//! | reference | meaning |
//! |---|---|
//! | leaf mask | bits 5..0 = shard, bits 31..6 = index into its `leaf_masks` |
//! | node, bit 31 = 1 | a level-3 node; bits 5..0 = shard, bits 30..6 = offset of its header in `cubes` |
//! | node, bit 31 = 0 | a node above level 3; bits 5..0 = shard, bits 30..6 = offset of its header in `inner` |
//!
//! Worked value: the level-3 node at word 5 of shard 3 is `0x8000_0143`.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

use adumbra_scene::random::mix;
use hashbrown::HashTable;

use crate::store::paged::{PagedVec, Spill};
use adumbra::layout::plain::{STATE_LIT, STATE_MIXED, STATE_SHADOWED};

const CUBE_BIT: u32 = 1 << 31;
const SHARD_BITS: u32 = 6;
const SHARDS: usize = 1 << SHARD_BITS;
/// Number of words or leaf masks that a shard's references can address.
const SHARD_LIMIT: usize = 1 << (31 - SHARD_BITS);
/// Size in bytes of a graph that uses all 31-bit word numbers.
const GRAPH_LIMIT_BYTES: u64 = 4 << 31;
/// Number of words of the longest node.
pub(crate) const MAX_WORDS: usize = 9;

/// The content of a cube of voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeState {
    /// Every defined voxel is shadowed.
    Shadowed,
    /// Every defined voxel is lit.
    Lit,
    /// Both lit and shadowed voxels; holds a reference into the store.
    Mixed(u32),
}

/// Leaf masks and nodes without duplicates.
#[derive(Default)]
pub struct NodeStore {
    shards: Shards,
    spill: Option<Arc<Spill>>,
    graph_bytes: AtomicU64,
    full: AtomicBool,
}

struct Shards([Mutex<Shard>; SHARDS]);

impl Default for Shards {
    fn default() -> Self {
        Self(std::array::from_fn(|_| Mutex::default()))
    }
}

#[derive(Default)]
pub(crate) struct Shard {
    pub(crate) leaf_masks: PagedVec<u64>,
    pub(crate) cubes: PagedVec<u32>,
    pub(crate) inner: PagedVec<u32>,
    leaf_mask_table: HashTable<u32>,
    cube_table: HashTable<u32>,
    inner_table: HashTable<u32>,
}

impl NodeStore {
    /// Creates an empty store whose contents go to `spill`, if there is one.
    pub(crate) fn new(spill: Option<&Arc<Spill>>) -> Self {
        let shard = || Shard {
            leaf_masks: PagedVec::new(spill),
            cubes: PagedVec::new(spill),
            inner: PagedVec::new(spill),
            ..Shard::default()
        };
        let shards = Shards(std::array::from_fn(|_| Mutex::new(shard())));
        Self { shards, spill: spill.cloned(), ..Self::default() }
    }

    /// Stores a leaf mask, 1 = lit, and returns its state.
    pub fn leaf_mask(&self, mask: u64) -> NodeState {
        match mask {
            0 => return NodeState::Shadowed,
            u64::MAX => return NodeState::Lit,
            _ => {}
        }
        let hash = mix(mask);
        let (number, mut shard) = self.shard_of(hash);
        let Shard { leaf_masks, leaf_mask_table, .. } = &mut *shard;
        if leaf_mask_table.len() == leaf_mask_table.capacity() {
            self.grow(leaf_mask_table, |table| {
                let hash = |i: &u32| mix(leaf_masks.get(*i as usize));
                for i in 0..leaf_masks.len() as u32 {
                    table.insert_unique(hash(&i), i, hash);
                }
            });
        }
        let same = |i: &u32| leaf_masks.get(*i as usize) == mask;
        let entry = leaf_mask_table.entry(hash, same, |i| mix(leaf_masks.get(*i as usize)));
        let index = *entry.or_insert(leaf_masks.len() as u32).get();
        if index as usize == leaf_masks.len() {
            leaf_masks.push(mask);
            self.note(8, leaf_masks.len());
        }
        NodeState::Mixed(index << SHARD_BITS | number)
    }

    /// Stores a level-3 node with these leaf masks, z = 0 first, and returns its state.
    pub fn cube(&self, leaf_masks: &[NodeState; 8]) -> NodeState {
        match self.intern(leaf_masks, |s| (&mut s.cubes, &mut s.cube_table)) {
            NodeState::Mixed(reference) => NodeState::Mixed(reference | CUBE_BIT),
            uniform => uniform,
        }
    }

    /// Stores a node above level 3 with these children, in child order, and returns its state.
    pub fn inner(&self, children: &[NodeState; 8]) -> NodeState {
        self.intern(children, |s| (&mut s.inner, &mut s.inner_table))
    }

    /// Whether more has been stored than references, or numbers, can address. The contents are then unusable.
    pub(crate) fn is_full(&self) -> bool {
        self.full.load(Ordering::Relaxed)
    }

    /// Bytes of the graph itself, without tables.
    pub fn graph_bytes(&self) -> u64 {
        self.graph_bytes.load(Ordering::Relaxed)
    }

    /// Bytes that numbering needs in addition to the graph and its copy.
    pub(crate) fn numbers_bytes(&self) -> u64 {
        self.shards.0.iter().map(|s| 4 * lock(s).leaf_masks.len() as u64).sum()
    }

    /// Bytes held apart from what is paged: tables, and contents with spare capacity.
    pub fn memory_bytes(&self) -> u64 {
        let bytes = |s: &Shard| {
            let tables = [&s.leaf_mask_table, &s.cube_table, &s.inner_table];
            let table_bytes: usize = tables.iter().map(|t| t.allocation_size()).sum();
            s.leaf_masks.memory_bytes() + s.cubes.memory_bytes() + s.inner.memory_bytes() + table_bytes
        };
        self.shards.0.iter().map(|s| bytes(&lock(s)) as u64).sum()
    }

    /// Returns the shards, with their tables freed, and the spill.
    pub(crate) fn into_shards(self) -> (Vec<Shard>, Option<Arc<Spill>>) {
        let shards = self.shards.0.into_iter().map(|s| {
            let shard = s.into_inner().unwrap_or_else(|e| e.into_inner());
            Shard { leaf_masks: shard.leaf_masks, cubes: shard.cubes, inner: shard.inner, ..Shard::default() }
        });
        (shards.collect(), self.spill)
    }

    fn shard_of(&self, hash: u64) -> (u32, MutexGuard<'_, Shard>) {
        // The tables use the lowest and the highest bits of the hash.
        let number = (hash >> 40) as usize % SHARDS;
        (number as u32, lock(&self.shards.0[number]))
    }

    /// Replaces a full table by one twice as large, which `fill` fills. The old table is freed first, so that both are
    /// never held at once.
    fn grow(&self, table: &mut HashTable<u32>, fill: impl FnOnce(&mut HashTable<u32>)) {
        let (capacity, before) = (table.capacity(), table.allocation_size());
        *table = HashTable::new();
        let mut larger = HashTable::with_capacity((2 * capacity).max(MIN_CAPACITY));
        if let Some(spill) = &self.spill {
            spill.give_up(larger.allocation_size().saturating_sub(before) as u64);
        }
        fill(&mut larger);
        *table = larger;
    }

    fn note(&self, bytes: usize, length: usize) {
        let before = self.graph_bytes.fetch_add(bytes as u64, Ordering::Relaxed);
        // Leaf masks are counted too, so this triggers somewhat before the numbers run out.
        if length >= SHARD_LIMIT || before >= GRAPH_LIMIT_BYTES {
            self.full.store(true, Ordering::Relaxed);
        }
    }

    fn intern(
        &self,
        children: &[NodeState; 8],
        pick: impl Fn(&mut Shard) -> (&mut PagedVec<u32>, &mut HashTable<u32>),
    ) -> NodeState {
        let mut buffer = [0; MAX_WORDS];
        let length = encode(children, &mut buffer);
        let words = &buffer[..length];
        match words[0] {
            0 => return NodeState::Shadowed,
            ALL_LIT => return NodeState::Lit,
            _ => {}
        }
        let hash = hash_words(words);
        let (number, mut shard) = self.shard_of(hash);
        let (arena, table) = pick(&mut shard);
        if table.len() == table.capacity() {
            self.grow(table, |table| {
                let mut at = 0;
                while at < arena.len() && !arena.has_failed() {
                    let (hash, length) = node_at(arena, at, |words| (hash_words(words), words.len()));
                    table.insert_unique(hash, at as u32, |o| node_at(arena, *o as usize, hash_words));
                    at += length;
                }
            });
        }
        let same = |o: &u32| node_at(arena, *o as usize, |found| found == words);
        let next = arena.len() as u32;
        let entry = table.entry(hash, same, |o| node_at(arena, *o as usize, hash_words));
        let offset = *entry.or_insert(next).get();
        if offset == next {
            arena.extend_from_slice(words);
            self.note(4 * length, arena.len());
        }
        NodeState::Mixed((offset << SHARD_BITS | number) & !CUBE_BIT)
    }
}

/// Capacity of the smallest table.
const MIN_CAPACITY: usize = 14;

/// Calls `f` with the words of the node at `at`.
fn node_at<R>(words: &PagedVec<u32>, at: usize, f: impl FnOnce(&[u32]) -> R) -> R {
    words.with::<MAX_WORDS, R>(at, node_length, f)
}

/// Returns the number of words of a node with this header.
pub(crate) fn node_length(header: u32) -> usize {
    1 + (header & 0xaaaa).count_ones() as usize
}

fn lock(shard: &Mutex<Shard>) -> MutexGuard<'_, Shard> {
    shard.lock().unwrap_or_else(|e| e.into_inner())
}

/// The parts of a node's reference.
pub(crate) struct Place {
    pub(crate) is_cube: bool,
    pub(crate) shard: usize,
    /// Offset of the header.
    pub(crate) offset: usize,
}

impl Place {
    pub(crate) fn of(reference: u32) -> Self {
        Self {
            is_cube: reference & CUBE_BIT != 0,
            shard: reference as usize % SHARDS,
            offset: ((reference & !CUBE_BIT) >> SHARD_BITS) as usize,
        }
    }
}

/// Returns shard and index of a leaf mask.
pub(crate) fn leaf_mask_place(reference: u32) -> (usize, usize) {
    (reference as usize % SHARDS, (reference >> SHARD_BITS) as usize)
}

/// Returns the children of the node with these words.
pub(crate) fn children_of(words: &[u32]) -> [NodeState; 8] {
    let header = words[0];
    let mut next = 0;
    std::array::from_fn(|c| match header >> (2 * c) & 3 {
        STATE_SHADOWED => NodeState::Shadowed,
        STATE_LIT => NodeState::Lit,
        _ => {
            next += 1;
            NodeState::Mixed(words[next])
        }
    })
}

/// Encodes header and pointers of a node, and returns the number of words.
pub(crate) fn encode(children: &[NodeState; 8], words: &mut [u32; MAX_WORDS]) -> usize {
    words[0] = 0;
    let mut length = 1;
    for (c, child) in children.iter().enumerate() {
        let state = match *child {
            NodeState::Shadowed => STATE_SHADOWED,
            NodeState::Lit => STATE_LIT,
            NodeState::Mixed(reference) => {
                words[length] = reference;
                length += 1;
                STATE_MIXED
            }
        };
        words[0] |= state << (2 * c);
    }
    length
}

/// The header of a node whose children are all lit.
const ALL_LIT: u32 = 0x5555;

fn hash_words(words: &[u32]) -> u64 {
    words.iter().fold(words.len() as u64, |h, w| mix(h ^ u64::from(*w)))
}
