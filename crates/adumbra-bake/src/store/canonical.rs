//! Canonical numbering of a graph: pre-order of first visit over the top grid, whatever order the nodes were made in.

use crate::store::graph::{MAX_WORDS, Place, Shard, children_of, encode, leaf_mask_place, node_length};
use crate::store::paged::PagedVec;
use crate::store::{NodeState, NodeStore};
use adumbra::layout::plain::{Dag, LIT, SHADOWED};

const UNVISITED: u32 = u32::MAX;
/// Bit of a header in the store: the node has been copied, and the other bits are its number. Headers use 16 bits,
/// numbers 31.
const COPIED: u32 = 1 << 31;

/// A numbered graph whose words may be on disk; otherwise like a [`Dag`].
pub(crate) struct PagedDag {
    pub(crate) size: [u32; 3],
    pub(crate) root_level: u32,
    pub(crate) top_dims: [u32; 3],
    pub(crate) top: Vec<u32>,
    pub(crate) nodes: PagedVec<u32>,
    pub(crate) leaf_masks: PagedVec<u64>,
}

impl NodeStore {
    /// Builds the finished graph under `top`, one root per cube of 2^`root_level` voxels, x fastest, then y, then z.
    ///
    /// Nodes that no root reaches are dropped. Cost: one visit per node. Memory: twice the graph, without tables.
    pub fn finish(self, size: [u32; 3], root_level: u32, top_dims: [u32; 3], top: &[NodeState]) -> Dag {
        self.number(size, root_level, top_dims, top).into_dag()
    }

    /// Numbers the graph like [`NodeStore::finish`], into pages of the store's spill if it has one. Memory: four bytes
    /// per leaf mask, and that of the spill.
    pub(crate) fn number(
        self,
        size: [u32; 3],
        root_level: u32,
        top_dims: [u32; 3],
        top: &[NodeState],
    ) -> PagedDag {
        let (shards, spill) = self.into_shards();
        let mut numbering = Numbering {
            leaf_mask_numbers: shards.iter().map(|s| vec![UNVISITED; s.leaf_masks.len()]).collect(),
            nodes: PagedVec::new(spill.as_ref()),
            leaf_masks: PagedVec::new(spill.as_ref()),
            shards,
        };
        numbering.nodes.reserve_exact(numbering.shards.iter().map(|s| s.cubes.len() + s.inner.len()).sum());
        numbering.leaf_masks.reserve_exact(numbering.shards.iter().map(|s| s.leaf_masks.len()).sum());
        let top = top
            .iter()
            .map(|root| match *root {
                NodeState::Lit => LIT,
                NodeState::Shadowed => SHADOWED,
                NodeState::Mixed(reference) => numbering.node(reference),
            })
            .collect();
        let Numbering { nodes, leaf_masks, .. } = numbering;
        PagedDag { size, root_level, top_dims, top, nodes, leaf_masks }
    }
}

impl PagedDag {
    /// Loads the whole graph into memory.
    pub(crate) fn into_dag(self) -> Dag {
        let Self { size, root_level, top_dims, top, nodes, leaf_masks, .. } = self;
        Dag { size, root_level, top_dims, top, nodes: nodes.into_vec(), leaf_masks: leaf_masks.into_vec() }
    }

    /// Bytes of nodes and leaf masks.
    pub(crate) fn graph_bytes(&self) -> u64 {
        4 * self.nodes.len() as u64 + 8 * self.leaf_masks.len() as u64
    }
}

struct Numbering {
    shards: Vec<Shard>,
    leaf_mask_numbers: Vec<Vec<u32>>,
    nodes: PagedVec<u32>,
    leaf_masks: PagedVec<u64>,
}

impl Numbering {
    /// Returns the number of a node. At the first visit, numbers the node and everything below it. Recursion depth: the
    /// number of levels.
    fn node(&mut self, reference: u32) -> u32 {
        let Place { is_cube, shard, offset } = Place::of(reference);
        let from = &mut self.shards[shard];
        let stored = if is_cube { &mut from.cubes } else { &mut from.inner };
        let copied_length = |header| if header & COPIED != 0 { 1 } else { node_length(header) };
        let mut words = [0; MAX_WORDS];
        let length = stored.with::<MAX_WORDS, _>(offset, copied_length, |found| {
            words[..found.len()].copy_from_slice(found);
            found.len()
        });
        if words[0] & COPIED != 0 {
            return words[0] & !COPIED;
        }
        // Data lost by a failing disk reads as zeros, so nodes would not be recognized as copied.
        if self.nodes.has_failed() {
            return 0;
        }
        let number = self.nodes.len() as u32;
        let mut children = children_of(&words);
        stored.overwrite(offset, &[COPIED | number]);
        self.nodes.extend_from_slice(&words[..length]);
        for child in &mut children {
            if let NodeState::Mixed(r) = child {
                *r = if is_cube { self.leaf_mask(*r) } else { self.node(*r) };
            }
        }
        encode(&children, &mut words);
        self.nodes.overwrite(number as usize, &words[..length]);
        number
    }

    fn leaf_mask(&mut self, reference: u32) -> u32 {
        let (shard, index) = leaf_mask_place(reference);
        let number = &mut self.leaf_mask_numbers[shard][index];
        if *number == UNVISITED {
            *number = self.leaf_masks.len() as u32;
            self.leaf_masks.push(self.shards[shard].leaf_masks.get(index));
        }
        *number
    }
}
