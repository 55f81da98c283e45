//! Merges subtrees that are mirror images of each other into one node. Source: Jaspe Villanueva, Marton,
//! Gobbetti, *SSVDAGs: Symmetry-aware Sparse Voxel DAGs* (2016), §3.
//!
//! A mirror is three bits, x = 4, y = 2, z = 1, as in a child number. Mirror f moves child i to position i ^
//! f and is passed on to every child. Mirrors compose by xor. Departures: leaves of eight voxels are stored
//! in the block of their parent, so a mirror permutes their bits and needs no extra bits. If a subtree is its
//! own mirror image, several mirrors of it mean the same, and the smallest of them is written. The paper
//! leaves that open, in which case equal blocks may differ in their bits.

use hashbrown::HashTable;
use hashbrown::hash_table::Entry;

use crate::tree::blocks::Blocks;
use crate::tree::word::{Node, Word};
use adumbra_scene::random::mix;

/// A graph whose inner words are [`Image`]s of `nodes`. Children precede their parents. No two nodes are
/// mirror images of each other.
pub(crate) struct Mirrored {
    /// The root node.
    pub(crate) root: Word,
    /// Eight siblings each.
    pub(crate) nodes: Vec<[Word; 8]>,
    smallest: Smallest,
}

/// A node under a mirror. In the 31 index bits of a word:
///
/// | bits | content |
/// |---|---|
/// | 30..3 | node |
/// | 2..0 | mirror: x, y, z |
///
/// Worked value: node 2, mirrored along x and z, is 0x15.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Image {
    /// Index of the node.
    pub(crate) node: u32,
    /// Mirrored along x (4), y (2), z (1).
    pub(crate) mirror: u8,
}

impl Image {
    /// Encodes the image as the index of a word.
    pub(crate) fn index(self) -> u32 {
        self.node << 3 | u32::from(self.mirror)
    }

    /// Decodes the index of a word.
    pub(crate) fn of(index: u32) -> Self {
        Self { node: index >> 3, mirror: (index & 7) as u8 }
    }
}

/// Returns the bits of a leaf with child i moved to i ^ mirror.
pub(crate) fn mirrored_mask(mask: u8, mirror: u8) -> u8 {
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

/// For each node and each mirror, the smallest mirror with the same result.
#[derive(Debug, Default)]
struct Smallest(Vec<[u8; 8]>);

impl Smallest {
    /// Returns the word under a mirror.
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

    /// Returns the block under a mirror.
    fn mirrored_block(&self, block: &[Word; 8], mirror: u8) -> [Word; 8] {
        std::array::from_fn(|i| self.mirrored(block[i ^ usize::from(mirror)], mirror))
    }
}

/// Merges blocks that are equal and, if `mirrors` is set, those that are mirror images of each other. Of the
/// eight images of a node the one with the smallest words is kept. Cost: linear, eight images per block.
pub(crate) fn mirror(tree: &Blocks, mirrors: bool) -> Mirrored {
    let mut smallest = Smallest::default();
    let mut nodes: Vec<[Word; 8]> = Vec::new();
    let mut table: HashTable<u32> = HashTable::new();
    let mut images: Vec<u32> = Vec::with_capacity(tree.blocks.len());
    for block in &tree.blocks {
        let block = block.map(|w| w.map_inner(|below| images[below as usize]));
        let (mut kept, mut mirror) = (block, 0);
        // Mirrors with the same result as the image kept so far; the first is the smallest.
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
                // Any two mirrors of `same` differ by a mirror that leaves the node unchanged.
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
    /// Turns every node to the image that is referenced most often, so that few pointers need mirror bits: a
    /// pointer to a node that is referenced once never does. Parents come first, because turning them changes
    /// the pointers to their children.
    pub(crate) fn turn_to_most_used(&mut self) {
        // Number of pointers to each node, by mirror.
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
