//! Subtrees that are mirror images of each other as one node. Source: Jaspe Villanueva, Marton, Gobbetti, *SSVDAGs:
//! Symmetry-aware Sparse Voxel DAGs* (2016), §3.
//!
//! A mirror is three bits, x = 4, y = 2, z = 1, as in a child number: mirror f takes child i to place i ^ f and is
//! passed on into every child. Mirrors compose by xor. Departures: leaves of eight voxels stand in their parent's block, so
//! a mirror permutes their bits and needs no bits of its own; and where a subtree is its own image, so that several
//! mirrors of it mean the same, the smallest of them is written. The paper leaves that open, and then two equal blocks
//! may differ in their bits.

use hashbrown::HashTable;
use hashbrown::hash_table::Entry;

use crate::dag::store::mix;
use crate::tree::blocks::Blocks;
use crate::tree::word::{Node, Word};

/// A graph whose inner words are [`Image`]s of `nodes`. Children stand before their parents, no two nodes are mirrored
/// images of each other.
pub(super) struct Mirrored {
    /// The whole space.
    pub(super) root: Word,
    /// Eight siblings each.
    pub(super) nodes: Vec<[Word; 8]>,
    smallest: Smallest,
}

/// A node as a mirror shows it. In a word's 31 index bits:
///
/// | bits | what |
/// |---|---|
/// | 30..3 | node |
/// | 2..0 | mirror: x, y, z |
///
/// Worked value: node 2, mirrored along x and z, is 0x15.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Image {
    /// Which node.
    pub(super) node: u32,
    /// Mirrored along x (4), y (2), z (1).
    pub(super) mirror: u8,
}

impl Image {
    /// Its place in a word.
    pub(super) fn index(self) -> u32 {
        self.node << 3 | u32::from(self.mirror)
    }

    /// What a word's index says.
    pub(super) fn of(index: u32) -> Self {
        Self { node: index >> 3, mirror: (index & 7) as u8 }
    }
}

/// A leaf's bits with child i at i ^ mirror.
pub(super) fn mirrored_mask(mask: u8, mirror: u8) -> u8 {
    let mut mask = mask;
    if mirror & 4 != 0 {
        mask = mask.rotate_left(4);
    }
    if mirror & 2 != 0 {
        mask = mask >> 2 & 0x33 | (mask & 0x33) << 2;
    }
    if mirror & 1 != 0 {
        mask = mask >> 1 & 0x55 | (mask & 0x55) << 1;
    }
    mask
}

/// For each node and each mirror the smallest mirror that shows the same.
#[derive(Debug, Default)]
struct Smallest(Vec<[u8; 8]>);

impl Smallest {
    /// The word as a mirror shows it.
    fn mirrored(&self, word: Word, mirror: u8) -> Word {
        match word.node() {
            Node::Uniform(_) => word,
            Node::Mask(mask) => Word::leaf(mirrored_mask(mask, mirror)),
            Node::Inner(index) => {
                let Image { node, mirror: own } = Image::of(index);
                let mirror = self.0[node as usize][usize::from(own ^ mirror)];
                Word::new(Node::Inner(Image { node, mirror }.index()))
            }
        }
    }

    /// The block as a mirror shows it.
    fn mirrored_block(&self, block: &[Word; 8], mirror: u8) -> [Word; 8] {
        std::array::from_fn(|i| self.mirrored(block[i ^ usize::from(mirror)], mirror))
    }
}

/// Merges blocks that are equal and, if `mirrors`, those that are images of each other. Of a node's eight images the
/// one with the smallest words is kept. Cost: linear, eight images a block.
pub(super) fn mirror(tree: &Blocks, mirrors: bool) -> Mirrored {
    let mut smallest = Smallest::default();
    let mut nodes: Vec<[Word; 8]> = Vec::new();
    let mut table: HashTable<u32> = HashTable::new();
    let mut images: Vec<u32> = Vec::with_capacity(tree.blocks.len());
    for block in &tree.blocks {
        let block = block.map(|w| w.map_inner(|below| images[below as usize]));
        let (mut kept, mut mirror) = (block, 0);
        // Mirrors that show the same as the one kept so far; the first is the smallest.
        let mut same = vec![0];
        for other in 1..if mirrors { 8 } else { 1 } {
            let image = smallest.mirrored_block(&block, other);
            match image.cmp(&kept) {
                std::cmp::Ordering::Less => {
                    (kept, mirror) = (image, other);
                    same = vec![other];
                }
                std::cmp::Ordering::Equal => same.push(other),
                std::cmp::Ordering::Greater => {}
            }
        }
        let equal = |&i: &u32| nodes[i as usize] == kept;
        let node = match table.entry(hash(&kept), equal, |&i| hash(&nodes[i as usize])) {
            Entry::Occupied(found) => *found.get(),
            Entry::Vacant(slot) => {
                let node = nodes.len() as u32;
                slot.insert(node);
                // Any two mirrors of `same` differ by one that leaves the node as it is.
                let unchanged = |m: u8| same.iter().map(|s| m ^ s ^ mirror).fold(m, u8::min);
                smallest.0.push(std::array::from_fn(|m| unchanged(m as u8)));
                nodes.push(kept);
                node
            }
        };
        images.push(Image { node, mirror }.index());
    }
    Mirrored { root: tree.root.map_inner(|block| images[block as usize]), nodes, smallest }
}

impl Mirrored {
    /// Turns every node to the image that is pointed to most often, so that few pointers need mirror bits: none to a node
    /// that is pointed to once. Parents first, as they turn the pointers to their children.
    pub(super) fn turn_to_most_used(&mut self) {
        // Pointers to each node by mirror.
        let mut uses = vec![[0_u32; 8]; self.nodes.len()];
        let mut turns = vec![0_u8; self.nodes.len()];
        let count = |word: Word, uses: &mut [[u32; 8]]| {
            if let Some(index) = word.inner() {
                let image = Image::of(index);
                uses[image.node as usize][usize::from(image.mirror)] += 1;
            }
        };
        count(self.root, &mut uses);
        for node in (0..self.nodes.len()).rev() {
            let most = (0..8).rev().max_by_key(|&m| uses[node][usize::from(m)]).unwrap_or(0);
            turns[node] = most;
            self.nodes[node] = self.smallest.mirrored_block(&self.nodes[node], most);
            for &word in &self.nodes[node] {
                count(word, &mut uses);
            }
        }
        let turned = |word: Word| match word.node() {
            Node::Inner(index) => self.smallest.mirrored(word, turns[Image::of(index).node as usize]),
            Node::Uniform(_) | Node::Mask(_) => word,
        };
        for word in self.nodes.as_flattened_mut().iter_mut().chain([&mut self.root]) {
            *word = turned(*word);
        }
    }
}

fn hash(words: &[Word; 8]) -> u64 {
    words.iter().fold(0, |h, w| mix(h ^ u64::from(w.0)))
}
