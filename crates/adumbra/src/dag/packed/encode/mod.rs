//! [`Dag`] → [`PackedDag`]: levels from the bottom up, so that a node's size is known before its parents'.
//!
//! The bytes follow from the graph alone: nodes are taken in the order of its words, pools are sorted by references and,
//! where those are equal, by that order. Memory: the packed graph, and 14 bytes a node; the plain one may be paged.

mod graph;
mod keys;
mod place;

use super::node::{Cube, LL, LM, LS, M2, MM, MS, SS};
use super::{MAX_SHARED_SLABS, MAX_UNITS, PackedDag};
use crate::dag::{Dag, GraphError, GraphPlace, PagedDag, SHADOWED, SLAB_NODE_LEVEL, TooLarge};
use graph::{Child, Graph};
use keys::Keys;

/// Why a graph has no packed form.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PackError {
    /// The graph itself is not valid.
    #[error("the graph is not valid: {0}")]
    Graph(#[from] GraphError),
    /// Behind something shadowed lies something lit.
    #[error(
        "{place}, of level {level}, has a column that is shadowed before it is lit: only the plain layout holds that; \
         write it with --layout plain"
    )]
    NotMonotone {
        /// The node, or the root cube.
        place: GraphPlace,
        /// Its level.
        level: u32,
    },
    /// More units than pointers can tell apart.
    #[error(
        "{units} units of nodes, but the packed layout holds at most {MAX_UNITS}; write it with --layout plain"
    )]
    TooLarge {
        /// At least so many.
        units: u64,
    },
    /// The grid is too large for the layout asked for.
    #[error(transparent)]
    Grid(#[from] TooLarge),
}

impl PackedDag {
    /// The packed form of a graph.
    ///
    /// Equal graphs have equal packed forms. Cost: two visits a node, and sorting those that have several parents.
    ///
    /// # Errors
    /// [`PackError`] where the graph is not valid, not monotone along z, or too large.
    pub fn of_dag(dag: &Dag) -> Result<Self, PackError> {
        dag.validate()?;
        Self::encode(dag, dag.size, |_| Ok(()))
    }

    /// The packed form of a graph that is valid. `make_room` is told, before it is taken, how many bytes will be held
    /// beside the graph.
    pub(crate) fn of_paged<E: From<PackError>>(
        dag: PagedDag,
        make_room: impl FnMut(u64) -> Result<(), E>,
    ) -> Result<Self, E> {
        let size = dag.size;
        if dag.nodes.is_paged() {
            Self::encode(&dag, size, make_room)
        } else {
            Self::encode(&dag.into_dag(), size, make_room)
        }
    }

    fn encode<E: From<PackError>>(
        graph: &impl Graph,
        size: [u32; 3],
        mut make_room: impl FnMut(u64) -> Result<(), E>,
    ) -> Result<Self, E> {
        let (root_level, top_dims) = (graph.head().root_level, graph.head().top_dims);
        let mut packed = Self { size, root_level, top_dims, ..Self::default() };
        let keys = Keys::new(graph);
        // References, places and words, and the pool that is sorted, eight bytes a node again.
        let nodes = keys.nodes();
        let held_bytes =
            Keys::bytes(graph.node_words(), nodes) + 20 * nodes as u64 + 8 * graph.slab_count() as u64;
        make_room(held_bytes)?;
        let mut encoder = Encoder::new(graph, keys)?;
        encoder.share_slabs();
        packed.slabs = encoder.shared.iter().map(|&slab| graph.slab(slab)).collect();
        for level in SLAB_NODE_LEVEL..=root_level {
            encoder.size_level(level)?;
        }
        encoder.write_columns(&mut packed)?;
        make_room(held_bytes + encoder.packed_bytes())?;
        encoder.write_nodes(&mut packed);
        Ok(packed)
    }
}

const NOT_SHARED: u32 = u32::MAX;

struct Encoder<'d, G> {
    graph: &'d G,
    keys: Keys,
    /// By key: pointers to the node.
    references: Vec<u32>,
    /// By key: see `place.rs`.
    places: Vec<u32>,
    /// By level: words of the nodes that are used at it, in order; once its pool is laid out, of those in it.
    words: Vec<Vec<u32>>,
    /// By slab: its place among the shared ones.
    slab_places: Vec<u32>,
    shared: Vec<u32>,
    /// By level: units of its pool.
    pool_units: Vec<u32>,
}

impl<'d, G: Graph> Encoder<'d, G> {
    fn new(graph: &'d G, keys: Keys) -> Result<Self, PackError> {
        let root_level = graph.head().root_level;
        let levels = root_level as usize + 1;
        let mut encoder = Self {
            graph,
            references: vec![0; keys.nodes()],
            keys,
            places: Vec::new(),
            words: vec![Vec::new(); levels],
            slab_places: Vec::new(),
            shared: Vec::new(),
            pool_units: vec![0; levels],
        };
        for &root in graph.head().top.iter().filter(|&&root| root < SHADOWED) {
            encoder.refer(root, root_level);
        }
        // A node's words lie before those of its children, so whatever refers to it at its own level has been met.
        let mut at = 0;
        while at < graph.node_words() {
            let level = encoder.keys.level(at as u32);
            encoder.visit(at as u32, level)?;
            at += graph.length(at as u32);
        }
        // Nodes without slabs that are used at further levels; the list grows while it is read.
        let mut next = 0;
        while let Some(&(word, level)) = encoder.keys.others.get(next) {
            encoder.visit(word, level)?;
            next += 1;
        }
        encoder.places = vec![0; encoder.references.len()];
        Ok(encoder)
    }

    fn refer(&mut self, word: u32, level: u32) {
        let key = self.keys.key_or_new(word, level);
        if key == self.references.len() {
            self.references.push(0);
        }
        self.references[key] += 1;
    }

    /// Counts what a node refers to.
    fn visit(&mut self, word: u32, level: u32) -> Result<(), PackError> {
        self.words[level as usize].push(word);
        if level > SLAB_NODE_LEVEL {
            let pairs = pairs(self.graph, word).ok_or_else(|| not_monotone(word, level))?;
            for &child in pairs.children() {
                self.refer(child, level - 1);
            }
        } else if self.cube(word).is_none() {
            return Err(not_monotone(word, level));
        }
        Ok(())
    }

    /// A node of level 3, if it is monotone.
    fn cube(&self, word: u32) -> Option<Cube> {
        let children = self.graph.children(word);
        let slabs = children.map(|child| match child {
            Child::Lit => u64::MAX,
            Child::Shadowed => 0,
            Child::Mixed(slab) => self.graph.slab(slab),
        });
        let mut cube = Cube::of_slabs(&slabs)?;
        let mut i = 0;
        for (k, child) in children.iter().enumerate() {
            if let Child::Mixed(slab) = *child
                && cube.changes >> k & 1 == 1
            {
                let place = self.slab_places.get(slab as usize).copied().unwrap_or(NOT_SHARED);
                cube.shared[i] = u16::try_from(place).ok();
                i += 1;
            }
        }
        Some(cube)
    }

    /// Chooses the slabs that are stored once, and drops those that in the end nothing needs.
    fn share_slabs(&mut self) {
        let graph = self.graph;
        let mut references = vec![0_u32; graph.slab_count()];
        for &word in &self.words[SLAB_NODE_LEVEL as usize] {
            let mut last = u64::MAX;
            for child in graph.children(word) {
                let mask = match child {
                    Child::Mixed(slab) => {
                        let mask = graph.slab(slab);
                        references[slab as usize] += u32::from(mask != last);
                        mask
                    }
                    Child::Lit => u64::MAX,
                    Child::Shadowed => 0,
                };
                last = mask;
            }
        }
        let mut chosen: Vec<u32> =
            (0..graph.slab_count() as u32).filter(|&slab| references[slab as usize] > 1).collect();
        chosen.sort_by_key(|&slab| (u32::MAX - references[slab as usize], slab));
        chosen.truncate(MAX_SHARED_SLABS);
        self.place_slabs(chosen);
        let mut needed = vec![false; self.shared.len()];
        for &word in &self.words[SLAB_NODE_LEVEL as usize] {
            for place in self.cube(word).iter().flat_map(Cube::shared_used) {
                needed[usize::from(place)] = true;
            }
        }
        let kept = self.shared.iter().zip(&needed).filter(|(_, needed)| **needed).map(|(slab, _)| *slab);
        self.place_slabs(kept.collect());
    }

    fn place_slabs(&mut self, shared: Vec<u32>) {
        self.slab_places.clear();
        self.slab_places.resize(self.graph.slab_count(), NOT_SHARED);
        for (place, &slab) in shared.iter().enumerate() {
            self.slab_places[slab as usize] = place as u32;
        }
        self.shared = shared;
    }
}

fn not_monotone(word: u32, level: u32) -> PackError {
    PackError::NotMonotone { place: GraphPlace::Node { word: word as usize }, level }
}

/// The quarters of a plain node above level 3: what they are, and their mixed children, those that are the same once.
#[derive(Default)]
struct Pairs {
    codes: u32,
    list: [u32; 8],
    count: usize,
}

impl Pairs {
    fn children(&self) -> &[u32] {
        &self.list[..self.count]
    }
}

/// None where a quarter is shadowed before it is lit.
fn pairs(graph: &impl Graph, word: u32) -> Option<Pairs> {
    let children = graph.children(word);
    let mut pairs = Pairs::default();
    for q in 0..4 {
        let (code, near, far) = match (children[2 * q], children[2 * q + 1]) {
            (Child::Shadowed, Child::Shadowed) => (SS, None, None),
            (Child::Lit, Child::Lit) => (LL, None, None),
            (Child::Lit, Child::Shadowed) => (LS, None, None),
            (Child::Lit, Child::Mixed(far)) => (LM, None, Some(far)),
            (Child::Mixed(near), Child::Shadowed) => (MS, Some(near), None),
            (Child::Mixed(near), Child::Mixed(far)) if near == far => (MM, Some(near), None),
            (Child::Mixed(near), Child::Mixed(far)) => (M2, Some(near), Some(far)),
            (Child::Shadowed, _) | (Child::Mixed(_), Child::Lit) => return None,
        };
        pairs.codes |= code << (3 * q);
        for child in near.into_iter().chain(far) {
            pairs.list[pairs.count] = child;
            pairs.count += 1;
        }
    }
    Some(pairs)
}
