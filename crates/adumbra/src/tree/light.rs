//! The light-aligned graph as the paper's tree, and back: the same voxels, and on the way back the same words.
//!
//! The tree's cube has the top grid's lowest corner and 2^depth voxels a side, the fewest that cover the grid; what lies
//! outside the grid is lit, as [`Dag::voxel`] has it. A level-3 node's slabs of 8 × 8 × 1 (bit y·8 + x) become two levels
//! of octree nodes and leaves of eight voxels, child `(x << 2) | (y << 1) | z`. Both ways equal contents are stored once and
//! the result is numbered in order of first visit, so each form follows from the voxels alone. Below level 3 a graph
//! has slabs and above it octants: a node means the same at two levels only above, so what is known is known by node
//! *and* level.

use std::collections::HashMap;

use super::graph::{MAX_DEPTH, VoxelTree};
use super::morton;
use super::reduce::{Interned, Sink};
use super::word::{Node, Word};
use crate::dag::store::{NodeState, NodeStore};
use crate::dag::{
    Dag, GraphError, LIT, MAX_CONVERTED_ROOTS, MAX_ROOT_LEVEL, SHADOWED, SLAB_NODE_LEVEL, STATE_LIT,
    STATE_MIXED, STATE_SHADOWED,
};

/// Most root cubes of a graph that is made from a tree: a bake has some thousands.
pub const MAX_ROOTS: u64 = MAX_CONVERTED_ROOTS;
/// Most bytes of a graph that is made from a tree: the store's references have 31 bits, for words.
const MAX_GRAPH_BYTES: u64 = (1 << 31) * 4 - (1 << 20);

/// Why a graph has no tree, or a tree no graph.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LightTreeError {
    /// The root level is out of range.
    #[error("root level {root_level} is not from {SLAB_NODE_LEVEL} to {MAX_ROOT_LEVEL}; bake it again")]
    RootLevel {
        /// The level given.
        root_level: u32,
    },
    /// The cube around the grid has too many levels.
    #[error(
        "a cube around {size:?} voxels has {depth} levels, but a tree has at most {MAX_DEPTH}; bake at a lower --resolution"
    )]
    TooDeep {
        /// Voxels along each axis.
        size: [u32; 3],
        /// Levels that they need.
        depth: u32,
    },
    /// The top grid is larger than any bake's.
    #[error("a top grid of {roots} roots, but at most {MAX_ROOTS} are taken; bake it again")]
    TooManyRoots {
        /// Roots that the size and the root level ask for.
        roots: u128,
    },
    /// The result does not fit 31-bit indices.
    #[error("the result has more words than 31 bits can count; bake at a lower --resolution")]
    TooManyWords,
    /// The tree's cube is not the one around the grid.
    #[error(
        "a tree of {depth} levels, but a grid of {size:?} voxels needs {expected}; give the grid that it was made from"
    )]
    WrongDepth {
        /// Levels of the tree.
        depth: u32,
        /// Voxels along each axis.
        size: [u32; 3],
        /// Levels that they need.
        expected: u32,
    },
    /// The graph cannot be walked.
    #[error("the graph is not valid: {0}; bake it again")]
    Graph(#[from] GraphError),
}

impl VoxelTree {
    /// The tree of a light-aligned graph. Cost: one visit a node (a node without slabs: one a level that it serves).
    ///
    /// # Errors
    /// [`LightTreeError`] where the graph is not valid or the tree would be too deep.
    pub fn of_dag(dag: &Dag) -> Result<Self, LightTreeError> {
        let depth = tree_depth(dag.size, dag.root_level)?;
        dag.validate()?;
        let mut work =
            ToTree { dag, blocks: Interned::default(), known: Known::new(dag.nodes.len(), Word::LIT) };
        let root = work.top([0; 3], depth)?;
        Ok(work.blocks.finish(root).number(depth))
    }
}

/// The light-aligned graph of `size` voxels that a tree answers like; the inverse of [`VoxelTree::of_dag`] for every
/// graph in which equal nodes are one, as a bake makes it. Cost: one visit a block and level at which it stands.
///
/// # Errors
/// [`LightTreeError`] where the tree's cube is not the one around that grid.
pub fn dag_of_tree(tree: &VoxelTree, size: [u32; 3], root_level: u32) -> Result<Dag, LightTreeError> {
    let expected = tree_depth(size, root_level)?;
    if tree.depth != expected {
        return Err(LightTreeError::WrongDepth { depth: tree.depth, size, expected });
    }
    let dims = Dag::top_dims_covering(size, root_level);
    let roots = dims.iter().map(|&n| u128::from(n)).product();
    if roots > u128::from(MAX_ROOTS) {
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

/// Levels of the smallest cube of 2^n voxels a side that covers the top grid.
///
/// # Errors
/// [`LightTreeError::RootLevel`], [`LightTreeError::TooDeep`].
pub fn tree_depth(size: [u32; 3], root_level: u32) -> Result<u32, LightTreeError> {
    if !(SLAB_NODE_LEVEL..=MAX_ROOT_LEVEL).contains(&root_level) {
        return Err(LightTreeError::RootLevel { root_level });
    }
    let dims = Dag::top_dims_covering(size, root_level);
    let longest = dims.into_iter().fold(1, u32::max);
    let depth = root_level + longest.next_power_of_two().trailing_zeros();
    if depth > MAX_DEPTH { Err(LightTreeError::TooDeep { size, depth }) } else { Ok(depth) }
}

/// What a node has become, by node and level. Almost every node stands at one level.
struct Known<T> {
    first: Vec<(u8, T)>,
    others: HashMap<(u32, u8), T>,
}

impl<T: Copy> Known<T> {
    /// Level 0 marks a place that is free; no node that is kept here stands there.
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
    /// The part of the cube above the roots; `corner` in roots.
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
        let word = if level == SLAB_NODE_LEVEL {
            self.slabs(&children.map(|(state, index)| match state {
                STATE_SHADOWED => 0,
                STATE_LIT => u64::MAX,
                _ => dag.slabs[index as usize],
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

    /// 8 × 8 × 8 voxels, one slab a z.
    fn slabs(&mut self, slabs: &[u64; 8]) -> Result<Word, LightTreeError> {
        self.join(|work, quarter| {
            let q = morton::child_offset(quarter);
            work.join(|_, eighth| {
                let e = morton::child_offset(eighth);
                let lit = (0..8).filter(|&voxel| {
                    let v = morton::child_offset(voxel);
                    let [x, y, z] = [0, 1, 2].map(|a| 4 * q[a] + 2 * e[a] + v[a]);
                    slabs[z as usize] >> (8 * y + x) & 1 == 1
                });
                Ok(Word::leaf(lit.fold(0, |mask, voxel| mask | 1 << voxel)))
            })
        })
    }

    /// The word of a node with these children: a leaf where all are uniform, else a block.
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
        let state = if level == SLAB_NODE_LEVEL {
            let mut slabs = [0; 8];
            self.fill(word, level, [0; 3], &mut slabs);
            let states = slabs.map(|mask| self.store.slab(mask));
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

    /// Sets the bits of the lit voxels of a cube within 8 × 8 × 8 of them.
    fn fill(&self, word: Word, level: u32, corner: [u32; 3], slabs: &mut [u64; 8]) {
        match word.node() {
            Node::Uniform(false) => {}
            Node::Uniform(true) => {
                let [x, y, z] = corner;
                let side = 1 << level;
                let row = ((1_u64 << side) - 1) << x;
                let rows = (y..y + side).fold(0, |mask, y| mask | row << (8 * y));
                slabs[z as usize..(z + side) as usize].iter_mut().for_each(|slab| *slab |= rows);
            }
            // A checked tree has no node below its voxels.
            Node::Mask(_) | Node::Inner(_) if level == 0 => {}
            Node::Mask(_) | Node::Inner(_) => {
                for c in 0..8 {
                    self.fill(self.child(word, c), level - 1, morton::child_corner(corner, level, c), slabs);
                }
            }
        }
    }
}
