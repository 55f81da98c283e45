//! Hash-consing: every slab and every node is stored once; equal contents get equal references.
//!
//! Contents are compared in full before two nodes are taken as one; the hash only finds the candidates.
//!
//! | reference | meaning |
//! |---|---|
//! | slab | index into `slabs` |
//! | node, bit 31 = 1 | a level-3 node; bits 30..0 = offset of its header in `cubes` |
//! | node, bit 31 = 0 | a node above level 3; bits 30..0 = offset of its header in `inner` |

use hashbrown::HashTable;

use super::{STATE_LIT, STATE_MIXED, STATE_SHADOWED};

const CUBE_BIT: u32 = 1 << 31;

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
    pub(super) slabs: Vec<u64>,
    pub(super) cubes: Vec<u32>,
    pub(super) inner: Vec<u32>,
    slab_table: HashTable<u32>,
    cube_table: HashTable<u32>,
    inner_table: HashTable<u32>,
}

impl NodeStore {
    /// The state of a slab with this mask, 1 = lit.
    pub fn slab(&mut self, mask: u64) -> NodeState {
        match mask {
            0 => NodeState::Shadowed,
            u64::MAX => NodeState::Lit,
            _ => {
                let slabs = &self.slabs;
                let hash = |i: &u32| mix(slabs[*i as usize]);
                let entry = self.slab_table.entry(mix(mask), |i| slabs[*i as usize] == mask, hash);
                let index = *entry.or_insert(slabs.len() as u32).get();
                if index as usize == self.slabs.len() {
                    self.slabs.push(mask);
                }
                NodeState::Mixed(index)
            }
        }
    }

    /// The state of a level-3 node with these slabs, z = 0 first.
    pub fn cube(&mut self, slabs: &[NodeState; 8]) -> NodeState {
        match intern(&mut self.cubes, &mut self.cube_table, slabs) {
            NodeState::Mixed(offset) => NodeState::Mixed(offset | CUBE_BIT),
            uniform => uniform,
        }
    }

    /// The state of a node above level 3 with these children, in child order.
    pub fn inner(&mut self, children: &[NodeState; 8]) -> NodeState {
        intern(&mut self.inner, &mut self.inner_table, children)
    }

    /// Whether references stay within 31 bits, and finished pointers below the top grid's marks, after
    /// [`NodeStore::absorb`].
    pub fn has_room_for(&self, other: &Self) -> bool {
        let words = |f: fn(&Self) -> usize| f(self) + f(other);
        let (cubes, inner) = (words(|s| s.cubes.len()), words(|s| s.inner.len()));
        cubes.max(inner) < CUBE_BIT as usize && words(|s| s.slabs.len()) < u32::MAX as usize
    }

    /// Takes every node of `other` in and gives the new reference of each of `roots`.
    pub fn absorb(&mut self, other: &Self, roots: &mut [NodeState]) {
        let slab_map: Vec<u32> = other
            .slabs
            .iter()
            .map(|&mask| match self.slab(mask) {
                NodeState::Mixed(index) => index,
                NodeState::Lit | NodeState::Shadowed => unreachable!("a stored slab is mixed"),
            })
            .collect();
        let mut cube_map = vec![0; other.cubes.len()];
        let mut inner_map = vec![0; other.inner.len()];
        for_each_node(&other.cubes, |offset, children| {
            let state = self.cube(&children.map(|c| map_state(c, |slab| slab_map[slab as usize])));
            cube_map[offset as usize] = reference(state);
        });
        // Children are stored before their parents.
        for_each_node(&other.inner, |offset, children| {
            let moved = children.map(|c| map_state(c, |r| moved_node(&cube_map, &inner_map, r)));
            inner_map[offset as usize] = reference(self.inner(&moved));
        });
        for root in roots {
            *root = map_state(*root, |r| moved_node(&cube_map, &inner_map, r));
        }
    }

    /// Empties the store and keeps its memory.
    pub fn clear(&mut self) {
        self.slabs.clear();
        self.cubes.clear();
        self.inner.clear();
        self.slab_table.clear();
        self.cube_table.clear();
        self.inner_table.clear();
    }

    /// Bytes of the graph itself, without tables.
    pub fn graph_bytes(&self) -> u64 {
        (self.slabs.len() * 8 + (self.cubes.len() + self.inner.len()) * 4) as u64
    }

    /// Bytes held, with spare room, and with the tables as large as they are while one of them grows.
    pub fn memory_bytes(&self) -> u64 {
        let tables = [&self.slab_table, &self.cube_table, &self.inner_table];
        let table_bytes: usize = tables.iter().map(|t| t.allocation_size()).sum();
        let arenas = self.slabs.capacity() * 8 + (self.cubes.capacity() + self.inner.capacity()) * 4;
        (arenas + table_bytes * 3 / 2) as u64
    }

    /// The node behind a reference: whether it is of level 3, and its children.
    pub(super) fn children(&self, reference: u32) -> (bool, [NodeState; 8]) {
        let is_cube = reference & CUBE_BIT != 0;
        let words = if is_cube { &self.cubes } else { &self.inner };
        (is_cube, children_at(words, (reference & !CUBE_BIT) as usize).0)
    }

    pub(super) fn word_offset(reference: u32) -> usize {
        (reference & !CUBE_BIT) as usize
    }
}

fn moved_node(cube_map: &[u32], inner_map: &[u32], reference: u32) -> u32 {
    if reference & CUBE_BIT != 0 {
        cube_map[(reference & !CUBE_BIT) as usize]
    } else {
        inner_map[reference as usize]
    }
}

fn reference(state: NodeState) -> u32 {
    match state {
        NodeState::Mixed(r) => r,
        NodeState::Lit | NodeState::Shadowed => unreachable!("a stored node is mixed"),
    }
}

fn map_state(state: NodeState, map: impl FnOnce(u32) -> u32) -> NodeState {
    match state {
        NodeState::Mixed(r) => NodeState::Mixed(map(r)),
        uniform => uniform,
    }
}

/// Children of the node at `offset`, and how many words it takes.
fn children_at(words: &[u32], offset: usize) -> ([NodeState; 8], usize) {
    let header = words[offset];
    let mut length = 1;
    let children = std::array::from_fn(|c| match header >> (2 * c) & 3 {
        STATE_SHADOWED => NodeState::Shadowed,
        STATE_LIT => NodeState::Lit,
        _ => {
            length += 1;
            NodeState::Mixed(words[offset + length - 1])
        }
    });
    (children, length)
}

fn for_each_node(words: &[u32], mut visit: impl FnMut(u32, [NodeState; 8])) {
    let mut offset = 0;
    while offset < words.len() {
        let (children, length) = children_at(words, offset);
        visit(offset as u32, children);
        offset += length;
    }
}

/// Header and pointers of a node.
pub(super) fn encode(children: &[NodeState; 8], words: &mut [u32; 9]) -> usize {
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

fn intern(arena: &mut Vec<u32>, table: &mut HashTable<u32>, children: &[NodeState; 8]) -> NodeState {
    let mut buffer = [0; 9];
    let length = encode(children, &mut buffer);
    let words = &buffer[..length];
    match words[0] {
        0 => return NodeState::Shadowed,
        ALL_LIT => return NodeState::Lit,
        _ => {}
    }
    let length_at = |offset: u32| 1 + (arena[offset as usize] & 0xaaaa).count_ones() as usize;
    let node_at = |offset: u32| &arena[offset as usize..offset as usize + length_at(offset)];
    let next = arena.len() as u32;
    let entry = table.entry(hash_words(words), |o| node_at(*o) == words, |o| hash_words(node_at(*o)));
    let offset = *entry.or_insert(next).get();
    if offset == next {
        arena.extend_from_slice(words);
    }
    NodeState::Mixed(offset)
}

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
