//! Hash-consing: every slab and every node is stored once; equal contents get equal references. Many threads may store at
//! once.
//!
//! Contents are compared in full before two nodes are taken as one; the hash only finds the candidates. It also picks one
//! of 64 shards, each behind a lock of its own. References depend on who came first; contents and their number do not.
//! Contents may be paged out, tables may not: a full table is dropped and made anew, twice as large, by one walk along
//! the contents.
//!
//! | reference | meaning |
//! |---|---|
//! | slab | bits 5..0 = shard, bits 31..6 = index into its `slabs` |
//! | node, bit 31 = 1 | a level-3 node; bits 5..0 = shard, bits 30..6 = offset of its header in `cubes` |
//! | node, bit 31 = 0 | a node above level 3; bits 5..0 = shard, bits 30..6 = offset of its header in `inner` |
//!
//! Worked value: the level-3 node at word 5 of shard 3 is `0x8000_0143`.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

use hashbrown::HashTable;

use super::{STATE_LIT, STATE_MIXED, STATE_SHADOWED};
use crate::paged::{PagedVec, Spill};

const CUBE_BIT: u32 = 1 << 31;
const SHARD_BITS: u32 = 6;
const SHARDS: usize = 1 << SHARD_BITS;
/// Words or slabs that a shard's references can tell apart.
const SHARD_LIMIT: usize = 1 << (31 - SHARD_BITS);
/// Bytes of a graph whose words all have numbers, of 31 bits.
const GRAPH_LIMIT_BYTES: u64 = 4 << 31;
/// Words of the longest node.
pub(super) const MOST_WORDS: usize = 9;

/// What a cube of voxels turned out to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeState {
    /// Every defined voxel is shadowed.
    Shadowed,
    /// Every defined voxel is lit.
    Lit,
    /// Both; a reference into the store.
    Mixed(u32),
}

/// Slabs and nodes without repetition.
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
pub(super) struct Shard {
    pub(super) slabs: PagedVec<u64>,
    pub(super) cubes: PagedVec<u32>,
    pub(super) inner: PagedVec<u32>,
    slab_table: HashTable<u32>,
    cube_table: HashTable<u32>,
    inner_table: HashTable<u32>,
}

impl NodeStore {
    /// An empty store whose contents go to `spill`, if there is one.
    pub(crate) fn new(spill: Option<&Arc<Spill>>) -> Self {
        let shard = || Shard {
            slabs: PagedVec::new(spill),
            cubes: PagedVec::new(spill),
            inner: PagedVec::new(spill),
            ..Shard::default()
        };
        let shards = Shards(std::array::from_fn(|_| Mutex::new(shard())));
        Self { shards, spill: spill.cloned(), ..Self::default() }
    }

    /// The state of a slab with this mask, 1 = lit.
    pub fn slab(&self, mask: u64) -> NodeState {
        match mask {
            0 => return NodeState::Shadowed,
            u64::MAX => return NodeState::Lit,
            _ => {}
        }
        let hash = mix(mask);
        let (number, mut shard) = self.shard_of(hash);
        let Shard { slabs, slab_table, .. } = &mut *shard;
        if slab_table.len() == slab_table.capacity() {
            self.grow(slab_table, |table| {
                let hash = |i: &u32| mix(slabs.get(*i as usize));
                for i in 0..slabs.len() as u32 {
                    table.insert_unique(hash(&i), i, hash);
                }
            });
        }
        let same = |i: &u32| slabs.get(*i as usize) == mask;
        let entry = slab_table.entry(hash, same, |i| mix(slabs.get(*i as usize)));
        let index = *entry.or_insert(slabs.len() as u32).get();
        if index as usize == slabs.len() {
            slabs.push(mask);
            self.note(8, slabs.len());
        }
        NodeState::Mixed(index << SHARD_BITS | number)
    }

    /// The state of a level-3 node with these slabs, z = 0 first.
    pub fn cube(&self, slabs: &[NodeState; 8]) -> NodeState {
        match self.intern(slabs, |s| (&mut s.cubes, &mut s.cube_table)) {
            NodeState::Mixed(reference) => NodeState::Mixed(reference | CUBE_BIT),
            uniform => uniform,
        }
    }

    /// The state of a node above level 3 with these children, in child order.
    pub fn inner(&self, children: &[NodeState; 8]) -> NodeState {
        self.intern(children, |s| (&mut s.inner, &mut s.inner_table))
    }

    /// More was stored than references, or numbers, can tell apart; what is stored is of no use any more.
    pub fn is_full(&self) -> bool {
        self.full.load(Ordering::Relaxed)
    }

    /// Bytes of the graph itself, without tables.
    pub fn graph_bytes(&self) -> u64 {
        self.graph_bytes.load(Ordering::Relaxed)
    }

    /// Bytes that numbering needs beside the graph and its copy.
    pub(crate) fn numbers_bytes(&self) -> u64 {
        self.shards.0.iter().map(|s| 4 * lock(s).slabs.len() as u64).sum()
    }

    /// Bytes held beside what is paged: tables, and contents with spare room.
    pub fn memory_bytes(&self) -> u64 {
        let bytes = |s: &Shard| {
            let tables = [&s.slab_table, &s.cube_table, &s.inner_table];
            let table_bytes: usize = tables.iter().map(|t| t.allocation_size()).sum();
            s.slabs.memory_bytes() + s.cubes.memory_bytes() + s.inner.memory_bytes() + table_bytes
        };
        self.shards.0.iter().map(|s| bytes(&lock(s)) as u64).sum()
    }

    /// The shards themselves, their tables freed, and where they spill.
    pub(super) fn into_shards(self) -> (Vec<Shard>, Option<Arc<Spill>>) {
        let shards = self.shards.0.into_iter().map(|s| {
            let shard = s.into_inner().unwrap_or_else(|e| e.into_inner());
            Shard { slabs: shard.slabs, cubes: shard.cubes, inner: shard.inner, ..Shard::default() }
        });
        (shards.collect(), self.spill)
    }

    fn shard_of(&self, hash: u64) -> (u32, MutexGuard<'_, Shard>) {
        // The tables use the lowest and the highest bits.
        let number = (hash >> 40) as usize % SHARDS;
        (number as u32, lock(&self.shards.0[number]))
    }

    /// Replaces a full table by one twice as large, which `fill` fills. The old one is gone before, so that the two are
    /// never held together.
    fn grow(&self, table: &mut HashTable<u32>, fill: impl FnOnce(&mut HashTable<u32>)) {
        let (capacity, before) = (table.capacity(), table.allocation_size());
        *table = HashTable::new();
        let mut larger = HashTable::with_capacity((2 * capacity).max(LEAST_CAPACITY));
        if let Some(spill) = &self.spill {
            spill.give_up(larger.allocation_size().saturating_sub(before) as u64);
        }
        fill(&mut larger);
        *table = larger;
    }

    fn note(&self, bytes: usize, length: usize) {
        let before = self.graph_bytes.fetch_add(bytes as u64, Ordering::Relaxed);
        // Slabs counted too, so somewhat before numbers end.
        if length >= SHARD_LIMIT || before >= GRAPH_LIMIT_BYTES {
            self.full.store(true, Ordering::Relaxed);
        }
    }

    fn intern(
        &self,
        children: &[NodeState; 8],
        pick: impl Fn(&mut Shard) -> (&mut PagedVec<u32>, &mut HashTable<u32>),
    ) -> NodeState {
        let mut buffer = [0; MOST_WORDS];
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

/// Entries that the smallest table has room for.
const LEAST_CAPACITY: usize = 14;

/// Has `f` look at the words of the node at `at`.
fn node_at<R>(words: &PagedVec<u32>, at: usize, f: impl FnOnce(&[u32]) -> R) -> R {
    words.with::<MOST_WORDS, R>(at, node_length, f)
}

/// Words of the node with this header.
pub(super) fn node_length(header: u32) -> usize {
    1 + (header & 0xaaaa).count_ones() as usize
}

fn lock(shard: &Mutex<Shard>) -> MutexGuard<'_, Shard> {
    shard.lock().unwrap_or_else(|e| e.into_inner())
}

/// A node's reference taken apart.
pub(super) struct Place {
    pub(super) is_cube: bool,
    pub(super) shard: usize,
    /// Offset of the header.
    pub(super) offset: usize,
}

impl Place {
    pub(super) fn of(reference: u32) -> Self {
        Self {
            is_cube: reference & CUBE_BIT != 0,
            shard: reference as usize % SHARDS,
            offset: ((reference & !CUBE_BIT) >> SHARD_BITS) as usize,
        }
    }
}

/// Shard and index of a slab.
pub(super) fn slab_place(reference: u32) -> (usize, usize) {
    (reference as usize % SHARDS, (reference >> SHARD_BITS) as usize)
}

/// Children of the node with these words.
pub(super) fn children_of(words: &[u32]) -> [NodeState; 8] {
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

/// Header and pointers of a node.
pub(super) fn encode(children: &[NodeState; 8], words: &mut [u32; MOST_WORDS]) -> usize {
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

/// Header of a node whose children are all lit.
const ALL_LIT: u32 = 0x5555;

fn hash_words(words: &[u32]) -> u64 {
    words.iter().fold(words.len() as u64, |h, w| mix(h ^ u64::from(*w)))
}

/// A 64-bit finaliser (Stafford's thirteenth variant of MurmurHash3's).
pub(crate) fn mix(v: u64) -> u64 {
    let v = v.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let v = (v ^ v >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let v = (v ^ v >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    v ^ v >> 31
}
