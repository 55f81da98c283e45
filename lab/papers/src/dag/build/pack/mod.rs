//! [`Dag`] → [`PackedDag`], level by level from the bottom up, so that a node's size is known before its
//! parents'.
//!
//! The bytes depend on the graph alone: nodes are processed in the order of their words, and pools are sorted
//! by the number of references, then by that order. Memory: the packed graph, and 14 bytes per node.

mod graph;
mod keys;
mod place;

use crate::dag::roots::LEAF_NODE_LEVEL;

use crate::dag::PackError;
use crate::dag::packed::node::{Cube, LL, LM, LS, M2, MM, MS, SS};
use crate::dag::packed::{MAX_SHARED_LEAF_MASKS, PackedDag};
use crate::dag::plain::{Dag, GraphPlace, SHADOWED};
use graph::{Child, children, length};
use keys::Keys;

/// Packs a graph.
///
/// Equal graphs have equal packed forms. Cost: two visits per node, and a sort of the nodes that have several
/// parents.
///
/// # Errors
/// Returns [`PackError`] if the graph is not valid, not monotone along z, or too large.
pub fn pack(dag: &Dag) -> Result<PackedDag, PackError> {
    dag.validate()?;
    let &Dag { size, root_level, top_dims, .. } = dag;
    let mut packed = PackedDag { size, root_level, top_dims, ..PackedDag::default() };
    let mut encoder = Encoder::new(dag)?;
    encoder.share_leaf_masks();
    packed.leaf_masks = encoder.shared.iter().map(|&leaf_mask| dag.leaf_masks[leaf_mask as usize]).collect();
    for level in LEAF_NODE_LEVEL..=root_level {
        encoder.size_level(level)?;
    }
    encoder.write_columns(&mut packed)?;
    encoder.write_nodes(&mut packed);
    Ok(packed)
}

const NOT_SHARED: u32 = u32::MAX;

struct Encoder<'d> {
    graph: &'d Dag,
    keys: Keys,
    /// By key: number of pointers to the node.
    references: Vec<u32>,
    /// By key: see `place.rs`.
    places: Vec<u32>,
    /// By level: words of the nodes used at that level, in order. After the pool is laid out, only those in
    /// the pool.
    words: Vec<Vec<u32>>,
    /// By leaf mask: its index among the shared leaf masks.
    leaf_mask_places: Vec<u32>,
    shared: Vec<u32>,
    /// By level: size of its pool in units.
    pool_units: Vec<u32>,
}

impl<'d> Encoder<'d> {
    fn new(graph: &'d Dag) -> Result<Self, PackError> {
        let root_level = graph.root_level;
        let keys = Keys::new(graph);
        let levels = root_level as usize + 1;
        let mut encoder = Self {
            graph,
            references: vec![0; keys.nodes()],
            keys,
            places: Vec::new(),
            words: vec![Vec::new(); levels],
            leaf_mask_places: Vec::new(),
            shared: Vec::new(),
            pool_units: vec![0; levels],
        };
        for &root in graph.top.iter().filter(|&&root| root < SHADOWED) {
            encoder.refer(root, root_level);
        }
        // A node's words come before those of its children, so everything that refers to it at its own level
        // has been visited.
        let mut at = 0;
        while at < graph.nodes.len() {
            let level = encoder.keys.level(at as u32);
            encoder.visit(at as u32, level)?;
            at += length(graph, at);
        }
        // Nodes without leaf masks that are used at further levels. The list grows while it is read.
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

    /// Counts the references from a node to its children.
    fn visit(&mut self, word: u32, level: u32) -> Result<(), PackError> {
        self.words[level as usize].push(word);
        if level > LEAF_NODE_LEVEL {
            let pairs = pairs(self.graph, word).ok_or_else(|| not_monotone(word, level))?;
            for &child in pairs.children() {
                self.refer(child, level - 1);
            }
        } else if self.cube(word).is_none() {
            return Err(not_monotone(word, level));
        }
        Ok(())
    }

    /// Returns a node of level 3, if it is monotone.
    fn cube(&self, word: u32) -> Option<Cube> {
        let children = children(self.graph, word);
        let leaf_masks = children.map(|child| match child {
            Child::Lit => u64::MAX,
            Child::Shadowed => 0,
            Child::Mixed(leaf_mask) => self.graph.leaf_masks[leaf_mask as usize],
        });
        let mut cube = Cube::from_leaf_masks(&leaf_masks)?;
        let mut i = 0;
        for (k, child) in children.iter().enumerate() {
            if let Child::Mixed(leaf_mask) = *child
                && cube.changes >> k & 1 == 1
            {
                let place = self.leaf_mask_places.get(leaf_mask as usize).copied().unwrap_or(NOT_SHARED);
                cube.shared[i] = u16::try_from(place).ok();
                i += 1;
            }
        }
        Some(cube)
    }

    /// Chooses the leaf masks that are stored once, and drops those that turn out not to be used.
    fn share_leaf_masks(&mut self) {
        let graph = self.graph;
        let mut references = vec![0_u32; graph.leaf_masks.len()];
        for &word in &self.words[LEAF_NODE_LEVEL as usize] {
            let mut last = u64::MAX;
            for child in children(graph, word) {
                let mask = match child {
                    Child::Mixed(leaf_mask) => {
                        let mask = graph.leaf_masks[leaf_mask as usize];
                        references[leaf_mask as usize] += u32::from(mask != last);
                        mask
                    }
                    Child::Lit => u64::MAX,
                    Child::Shadowed => 0,
                };
                last = mask;
            }
        }
        let mut chosen: Vec<u32> = (0..graph.leaf_masks.len() as u32)
            .filter(|&leaf_mask| references[leaf_mask as usize] > 1)
            .collect();
        chosen.sort_by_key(|&leaf_mask| (u32::MAX - references[leaf_mask as usize], leaf_mask));
        chosen.truncate(MAX_SHARED_LEAF_MASKS);
        self.place_leaf_masks(chosen);
        let mut needed = vec![false; self.shared.len()];
        for &word in &self.words[LEAF_NODE_LEVEL as usize] {
            for place in self.cube(word).iter().flat_map(Cube::shared_used) {
                needed[usize::from(place)] = true;
            }
        }
        let kept =
            self.shared.iter().zip(&needed).filter(|(_, needed)| **needed).map(|(leaf_mask, _)| *leaf_mask);
        self.place_leaf_masks(kept.collect());
    }

    fn place_leaf_masks(&mut self, shared: Vec<u32>) {
        self.leaf_mask_places.clear();
        self.leaf_mask_places.resize(self.graph.leaf_masks.len(), NOT_SHARED);
        for (place, &leaf_mask) in shared.iter().enumerate() {
            self.leaf_mask_places[leaf_mask as usize] = place as u32;
        }
        self.shared = shared;
    }
}

fn not_monotone(word: u32, level: u32) -> PackError {
    PackError::NotMonotone { place: GraphPlace::Node { word: word as usize }, level }
}

/// The quarters of a plain node above level 3: their codes, and their mixed children, with equal near and far
/// children listed once.
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

/// Returns `None` if a quarter is shadowed before it is lit.
fn pairs(graph: &Dag, word: u32) -> Option<Pairs> {
    let children = children(graph, word);
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
