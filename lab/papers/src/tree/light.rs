//! Converts the light-aligned graph to the paper's tree and back. The voxels are the same, and a round trip
//! restores the same words.
//!
//! The cube of the tree shares its lowest corner with the top grid and is the smallest with sides of 2^depth
//! voxels that covers the grid. Voxels outside the grid are lit, as in [`Dag`]. The leaf masks of a level-3
//! node, 8 × 8 × 1 voxels each (bit y·8 + x), become two levels of octree nodes and leaves of eight voxels,
//! child `(x << 2) | (y << 1) | z`. In both directions equal contents are stored once and the result is
//! numbered in order of first visit, so each form depends on the voxels alone. The nodes of a graph have leaf
//! masks at level 3 and octants above it, so a node has the same meaning at two levels only if both are above
//! level 3. Results are therefore cached by node *and* level.

use crate::dag::roots::{LEAF_NODE_LEVEL, MAX_ROOT_LEVEL, top_dims};
use std::collections::HashMap;

use crate::dag::MAX_CONVERTED_ROOTS;
use crate::dag::build::store::{NodeState, NodeStore};
use crate::dag::plain::{Dag, LIT, SHADOWED, STATE_LIT, STATE_MIXED, STATE_SHADOWED};
use crate::tree::error::LightTreeError;
use crate::tree::graph::VoxelTree;
use crate::tree::morton;
use crate::tree::reduce::{Interned, Sink};
use crate::tree::word::{MAX_DEPTH, Node, Word};

/// Maximum size in bytes of a graph that is made from a tree: the references of the store have 31 bits and
/// count words.
const MAX_GRAPH_BYTES: u64 = (1 << 31) * 4 - (1 << 20);

impl VoxelTree {
    /// Converts a light-aligned graph to a tree. Cost: one visit per node; a node without leaf masks is
    /// visited once per level at which it is used.
    ///
    /// # Errors
    /// Returns [`LightTreeError`] if the graph is not valid or the tree would be too deep.
    pub fn from_dag(dag: &Dag) -> Result<Self, LightTreeError> {
        let depth = tree_depth(dag.size, dag.root_level)?;
        dag.validate()?;
        let mut work =
            ToTree { dag, blocks: Interned::default(), known: Known::new(dag.nodes.len(), Word::LIT) };
        let root = work.top([0; 3], depth)?;
        Ok(work.blocks.finish(root).number(depth))
    }
}

/// Converts a tree to the light-aligned graph of `size` voxels with the same visibility. It is the inverse of
/// [`VoxelTree::from_dag`] for every graph in which equal nodes are merged, as in the output of a bake. Cost:
/// one visit per block and level at which the block is used.
///
/// # Errors
/// Returns [`LightTreeError`] if the cube of the tree is not the one around that grid.
pub fn dag_of_tree(tree: &VoxelTree, size: [u32; 3], root_level: u32) -> Result<Dag, LightTreeError> {
    let expected = tree_depth(size, root_level)?;
    if tree.depth != expected {
        return Err(LightTreeError::WrongDepth { depth: tree.depth, size, expected });
    }
    let dims = top_dims(size, root_level);
    let roots = dims.iter().map(|&n| u128::from(n)).product();
    if roots > u128::from(MAX_CONVERTED_ROOTS) {
        return Err(LightTreeError::TooManyRoots { roots });
    }
    let known = Known::new(tree.words.len() / 8, NodeState::Lit);
    let mut work = ToDag { tree, store: NodeStore::default(), known };
    let mut top = Vec::with_capacity(roots as usize);
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let mut word = Word(tree.words[0]);
                for level in (root_level..tree.depth).rev() {
                    word = work.child(word, morton::child([x, y, z], level - root_level));
                }
                top.push(work.node(word, root_level)?);
            }
        }
    }
    Ok(work.store.finish(size, root_level, dims, &top))
}

/// Returns the number of levels of the smallest cube with sides of 2^n voxels that covers the top grid.
///
/// # Errors
/// Returns [`LightTreeError::RootLevel`] or [`LightTreeError::TooDeep`].
pub fn tree_depth(size: [u32; 3], root_level: u32) -> Result<u32, LightTreeError> {
    if !(LEAF_NODE_LEVEL..=MAX_ROOT_LEVEL).contains(&root_level) {
        return Err(LightTreeError::RootLevel { root_level });
    }
    let dims = top_dims(size, root_level);
    let longest = dims.into_iter().fold(1, u32::max);
    let depth = root_level + longest.next_power_of_two().trailing_zeros();
    if depth > MAX_DEPTH { Err(LightTreeError::TooDeep { size, depth }) } else { Ok(depth) }
}

/// Caches the result of each converted node by node and level. Almost every node is used at one level only.
struct Known<T> {
    first: Vec<(u8, T)>,
    others: HashMap<(u32, u8), T>,
}

impl<T: Copy> Known<T> {
    /// Level 0 marks an empty entry; no cached node has level 0.
    fn new(nodes: usize, filler: T) -> Self {
        Self { first: vec![(0, filler); nodes], others: HashMap::new() }
    }

    fn get(&self, node: u32, level: u32) -> Option<T> {
        match self.first[node as usize] {
            (0, _) => None,
            (first, value) if u32::from(first) == level => Some(value),
            _ => self.others.get(&(node, level as u8)).copied(),
        }
    }

    fn put(&mut self, node: u32, level: u32, value: T) {
        match &mut self.first[node as usize] {
            free @ (0, _) => *free = (level as u8, value),
            _ => {
                self.others.insert((node, level as u8), value);
            }
        }
    }
}

struct ToTree<'d> {
    dag: &'d Dag,
    blocks: Interned,
    known: Known<Word>,
}

impl ToTree<'_> {
    /// Converts the part of the cube above the roots; `corner` is in roots.
    fn top(&mut self, corner: [u32; 3], level: u32) -> Result<Word, LightTreeError> {
        let dims = self.dag.top_dims;
        if (0..3).any(|a| corner[a] >= dims[a]) {
            return Ok(Word::LIT);
        }
        if level == self.dag.root_level {
            let [x, y, z] = corner.map(|c| c as usize);
            let entry = self.dag.top[(z * dims[1] as usize + y) * dims[0] as usize + x];
            return match entry {
                LIT => Ok(Word::LIT),
                SHADOWED => Ok(Word::SHADOWED),
                pointer => self.node(pointer, level),
            };
        }
        let above_roots = level - self.dag.root_level;
        self.join(|work, child| work.top(morton::child_corner(corner, above_roots, child), level - 1))
    }

    fn node(&mut self, pointer: u32, level: u32) -> Result<Word, LightTreeError> {
        if let Some(word) = self.known.get(pointer, level) {
            return Ok(word);
        }
        let dag = self.dag;
        let header = dag.nodes[pointer as usize];
        let mut next = pointer as usize;
        let children: [(u32, u32); 8] = std::array::from_fn(|c| {
            let state = header >> (2 * c) & 3;
            next += usize::from(state == STATE_MIXED);
            (state, if state == STATE_MIXED { dag.nodes[next] } else { 0 })
        });
        let word = if level == LEAF_NODE_LEVEL {
            self.leaf_masks(&children.map(|(state, index)| match state {
                STATE_SHADOWED => 0,
                STATE_LIT => u64::MAX,
                _ => dag.leaf_masks[index as usize],
            }))?
        } else {
            self.join(|work, child| match children[child as usize] {
                (STATE_SHADOWED, _) => Ok(Word::SHADOWED),
                (STATE_LIT, _) => Ok(Word::LIT),
                (_, below) => work.node(below, level - 1),
            })?
        };
        self.known.put(pointer, level, word);
        Ok(word)
    }

    /// Converts 8 × 8 × 8 voxels, one leaf mask per z.
    fn leaf_masks(&mut self, leaf_masks: &[u64; 8]) -> Result<Word, LightTreeError> {
        self.join(|work, quarter| {
            let q = morton::child_offset(quarter);
            work.join(|_, eighth| {
                let e = morton::child_offset(eighth);
                let lit = (0..8).filter(|&voxel| {
                    let v = morton::child_offset(voxel);
                    let [x, y, z] = [0, 1, 2].map(|a| 4 * q[a] + 2 * e[a] + v[a]);
                    leaf_masks[z as usize] >> (8 * y + x) & 1 == 1
                });
                Ok(Word::leaf(lit.fold(0, |mask, voxel| mask | 1 << voxel)))
            })
        })
    }

    /// Returns the word of a node with these children: a leaf if all are uniform, else a block.
    fn join(
        &mut self,
        child: impl Fn(&mut Self, u32) -> Result<Word, LightTreeError>,
    ) -> Result<Word, LightTreeError> {
        let (mut words, mut uniform, mut mask) = ([Word::LIT; 8], true, 0);
        for c in 0..8 {
            let word = child(self, c)?;
            words[c as usize] = word;
            match word.node() {
                Node::Uniform(lit) => mask |= u8::from(lit) << c,
                Node::Mask(_) | Node::Inner(_) => uniform = false,
            }
        }
        if uniform {
            return Ok(Word::leaf(mask));
        }
        self.blocks.block(&words).map_err(|_| LightTreeError::TooManyWords)
    }
}

struct ToDag<'t> {
    tree: &'t VoxelTree,
    store: NodeStore,
    known: Known<NodeState>,
}

impl ToDag<'_> {
    fn child(&self, word: Word, child: u32) -> Word {
        match word.node() {
            Node::Uniform(_) => word,
            Node::Mask(mask) if mask >> child & 1 == 1 => Word::LIT,
            Node::Mask(_) => Word::SHADOWED,
            Node::Inner(block) => Word(self.tree.words[(block + child) as usize]),
        }
    }

    fn node(&mut self, word: Word, level: u32) -> Result<NodeState, LightTreeError> {
        let block = match word.node() {
            Node::Uniform(true) => return Ok(NodeState::Lit),
            Node::Uniform(false) => return Ok(NodeState::Shadowed),
            Node::Mask(_) => None,
            Node::Inner(index) => Some(index / 8),
        };
        if let Some(known) = block.and_then(|b| self.known.get(b, level)) {
            return Ok(known);
        }
        if self.store.graph_bytes() > MAX_GRAPH_BYTES {
            return Err(LightTreeError::TooManyWords);
        }
        let state = if level == LEAF_NODE_LEVEL {
            let mut leaf_masks = [0; 8];
            self.fill(word, level, [0; 3], &mut leaf_masks);
            let states = leaf_masks.map(|mask| self.store.leaf_mask(mask));
            self.store.cube(&states)
        } else {
            let mut children = [NodeState::Lit; 8];
            for c in 0..8 {
                children[c as usize] = self.node(self.child(word, c), level - 1)?;
            }
            self.store.inner(&children)
        };
        if let Some(block) = block {
            self.known.put(block, level, state);
        }
        Ok(state)
    }

    /// Sets the bits of the lit voxels of a cube within a block of 8 × 8 × 8 voxels.
    fn fill(&self, word: Word, level: u32, corner: [u32; 3], leaf_masks: &mut [u64; 8]) {
        match word.node() {
            Node::Uniform(false) => {}
            Node::Uniform(true) => {
                let [x, y, z] = corner;
                let side = 1 << level;
                let row = ((1_u64 << side) - 1) << x;
                let rows = (y..y + side).fold(0, |mask, y| mask | row << (8 * y));
                leaf_masks[z as usize..(z + side) as usize]
                    .iter_mut()
                    .for_each(|leaf_mask| *leaf_mask |= rows);
            }
            // A checked tree has no nodes below the voxel level.
            Node::Mask(_) | Node::Inner(_) if level == 0 => {}
            Node::Mask(_) | Node::Inner(_) => {
                for c in 0..8 {
                    self.fill(
                        self.child(word, c),
                        level - 1,
                        morton::child_corner(corner, level, c),
                        leaf_masks,
                    );
                }
            }
        }
    }
}
