//! Canonical numbering of a graph: pre-order of first visit over the top grid, regardless of the order in
//! which the nodes were made.

use super::{
    MAX_WORDS, NodeRef, NodeState, NodeStore, Shard, children_of, encode, leaf_mask_place, node_length,
};
use crate::dag::plain::{Dag, LIT, SHADOWED};

const UNVISITED: u32 = u32::MAX;
/// Bit of a header in the store: the node has been copied, and the other bits are its number. Headers use 16
/// bits, numbers 31.
const COPIED: u32 = 1 << 31;

impl NodeStore {
    /// Builds the finished graph under `top`, one root per cube of 2^`root_level` voxels, x fastest, then y,
    /// then z.
    ///
    /// Nodes that no root reaches are dropped. Cost: one visit per node. Memory: twice the graph, without
    /// tables.
    pub fn finish(self, size: [u32; 3], root_level: u32, top_dims: [u32; 3], top: &[NodeState]) -> Dag {
        let shards = self.into_shards();
        let mut numbering = Numbering {
            leaf_mask_numbers: shards.iter().map(|s| vec![UNVISITED; s.leaf_masks.len()]).collect(),
            nodes: Vec::new(),
            leaf_masks: Vec::new(),
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
        Dag { size, root_level, top_dims, top, nodes, leaf_masks }
    }
}

struct Numbering {
    shards: Vec<Shard>,
    leaf_mask_numbers: Vec<Vec<u32>>,
    nodes: Vec<u32>,
    leaf_masks: Vec<u64>,
}

impl Numbering {
    /// Returns the number of a node. At the first visit, numbers the node and everything below it. Recursion
    /// depth: the number of levels.
    fn node(&mut self, reference: u32) -> u32 {
        let NodeRef { is_cube, shard, offset } = NodeRef::of(reference);
        let from = &mut self.shards[shard];
        let stored = &mut if is_cube { &mut from.cubes } else { &mut from.inner }[offset..];
        if stored[0] & COPIED != 0 {
            return stored[0] & !COPIED;
        }
        let length = node_length(stored[0]);
        let mut words = [0; MAX_WORDS];
        words[..length].copy_from_slice(&stored[..length]);
        let number = self.nodes.len();
        stored[0] = COPIED | number as u32;
        self.nodes.extend_from_slice(&words[..length]);
        let mut children = children_of(&words);
        for child in &mut children {
            if let NodeState::Mixed(r) = child {
                *r = if is_cube { self.leaf_mask(*r) } else { self.node(*r) };
            }
        }
        encode(&children, &mut words);
        self.nodes[number..number + length].copy_from_slice(&words[..length]);
        number as u32
    }

    fn leaf_mask(&mut self, reference: u32) -> u32 {
        let (shard, index) = leaf_mask_place(reference);
        let number = &mut self.leaf_mask_numbers[shard][index];
        if *number == UNVISITED {
            *number = self.leaf_masks.len() as u32;
            self.leaf_masks.push(self.shards[shard].leaf_masks[index]);
        }
        *number
    }
}
