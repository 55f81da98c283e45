//! Hash-consing: every leaf mask and every node is stored once, and equal contents get equal references.
//! Several threads may store concurrently.
//!
//! Contents are compared in full before two nodes are merged; the hash only finds candidates. The hash also
//! selects one of 64 shards, each behind its own lock. References depend on the order of insertion; the
//! contents and their number do not.
//!
//! | reference | meaning |
//! |---|---|
//! | leaf mask | bits 5..0 = shard, bits 31..6 = index into its `leaf_masks` |
//! | node, bit 31 = 1 | a level-3 node; bits 5..0 = shard, bits 30..6 = offset of its header in `cubes` |
//! | node, bit 31 = 0 | a node above level 3; bits 5..0 = shard, bits 30..6 = offset of its header in `inner` |
//!
//! Worked value: the level-3 node at word 5 of shard 3 is `0x8000_0143`.

mod canonical;

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard};

use adumbra_scene::random::mix;
use hashbrown::HashTable;

use crate::dag::plain::{STATE_LIT, STATE_MIXED, STATE_SHADOWED};

const CUBE_BIT: u32 = 1 << 31;
const SHARD_BITS: u32 = 6;
const SHARDS: usize = 1 << SHARD_BITS;
/// Number of words or leaf masks that a shard's references can address.
const SHARD_LIMIT: usize = 1 << (31 - SHARD_BITS);
/// Size in bytes of a graph that uses all 31-bit word numbers.
const GRAPH_LIMIT_BYTES: u64 = 4 << 31;
/// Number of words of the longest node.
const MAX_WORDS: usize = 9;

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
struct Shard {
    leaf_masks: Vec<u64>,
    cubes: Vec<u32>,
    inner: Vec<u32>,
    leaf_mask_table: HashTable<u32>,
    cube_table: HashTable<u32>,
    inner_table: HashTable<u32>,
}

impl NodeStore {
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
        let same = |i: &u32| leaf_masks[*i as usize] == mask;
        let entry = leaf_mask_table.entry(hash, same, |i| mix(leaf_masks[*i as usize]));
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
    pub(super) fn is_full(&self) -> bool {
        self.full.load(Ordering::Relaxed)
    }

    /// Bytes of the graph itself, without tables.
    pub fn graph_bytes(&self) -> u64 {
        self.graph_bytes.load(Ordering::Relaxed)
    }

    /// Bytes that numbering needs in addition to the graph and its copy.
    pub(super) fn numbers_bytes(&self) -> u64 {
        self.shards.0.iter().map(|s| 4 * lock(s).leaf_masks.len() as u64).sum()
    }

    /// Bytes held: tables, and contents with spare capacity.
    pub fn memory_bytes(&self) -> u64 {
        let bytes = |s: &Shard| {
            let tables = [&s.leaf_mask_table, &s.cube_table, &s.inner_table];
            let table_bytes: usize = tables.iter().map(|t| t.allocation_size()).sum();
            8 * s.leaf_masks.capacity() + 4 * (s.cubes.capacity() + s.inner.capacity()) + table_bytes
        };
        self.shards.0.iter().map(|s| bytes(&lock(s)) as u64).sum()
    }

    /// Returns the shards, with their tables freed.
    fn into_shards(self) -> Vec<Shard> {
        let shards = self.shards.0.into_iter().map(|s| {
            let shard = s.into_inner().unwrap_or_else(|e| e.into_inner());
            Shard { leaf_masks: shard.leaf_masks, cubes: shard.cubes, inner: shard.inner, ..Shard::default() }
        });
        shards.collect()
    }

    fn shard_of(&self, hash: u64) -> (u32, MutexGuard<'_, Shard>) {
        // The tables use the lowest and the highest bits of the hash.
        let number = (hash >> 40) as usize % SHARDS;
        (number as u32, lock(&self.shards.0[number]))
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
        pick: impl Fn(&mut Shard) -> (&mut Vec<u32>, &mut HashTable<u32>),
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
        let same = |o: &u32| node_at(arena, *o) == words;
        let next = arena.len() as u32;
        let entry = table.entry(hash, same, |o| hash_words(node_at(arena, *o)));
        let offset = *entry.or_insert(next).get();
        if offset == next {
            arena.extend_from_slice(words);
            self.note(4 * length, arena.len());
        }
        NodeState::Mixed((offset << SHARD_BITS | number) & !CUBE_BIT)
    }
}

/// Returns the words of the node at `at`.
fn node_at(words: &[u32], at: u32) -> &[u32] {
    let node = &words[at as usize..];
    &node[..node_length(node[0])]
}

/// Returns the number of words of a node with this header.
pub(super) fn node_length(header: u32) -> usize {
    1 + (header & 0xaaaa).count_ones() as usize
}

fn lock(shard: &Mutex<Shard>) -> MutexGuard<'_, Shard> {
    shard.lock().unwrap_or_else(|e| e.into_inner())
}

/// The parts of a node's reference.
struct NodeRef {
    is_cube: bool,
    shard: usize,
    /// Offset of the header.
    offset: usize,
}

impl NodeRef {
    fn of(reference: u32) -> Self {
        Self {
            is_cube: reference & CUBE_BIT != 0,
            shard: reference as usize % SHARDS,
            offset: ((reference & !CUBE_BIT) >> SHARD_BITS) as usize,
        }
    }
}

/// Returns shard and index of a leaf mask.
fn leaf_mask_place(reference: u32) -> (usize, usize) {
    (reference as usize % SHARDS, (reference >> SHARD_BITS) as usize)
}

/// Returns the children of the node with these words.
fn children_of(words: &[u32]) -> [NodeState; 8] {
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
fn encode(children: &[NodeState; 8], words: &mut [u32; MAX_WORDS]) -> usize {
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
