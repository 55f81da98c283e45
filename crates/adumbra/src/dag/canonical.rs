//! One numbering for one graph: pre-order of first visit over the top grid, whatever order the nodes were made in.

use super::store::{NodeState, NodeStore, Place, Shard, children_at, encode, slab_place};
use super::{Dag, LIT, SHADOWED};

const UNVISITED: u32 = u32::MAX;
/// Of a header in the store: the node has been copied, and the other bits are its number. Headers use 16 bits, numbers 31.
const COPIED: u32 = 1 << 31;

impl NodeStore {
    /// The finished graph under `top`, one root a cube of 2^`root_level` voxels, x fastest, then y, then z.
    ///
    /// Nodes that no root reaches are left behind. Cost: one visit a node; memory: the graph twice, without tables.
    pub fn finish(self, size: [u32; 3], root_level: u32, top_dims: [u32; 3], top: &[NodeState]) -> Dag {
        let shards = self.into_shards();
        let mut numbering = Numbering {
            slab_numbers: shards.iter().map(|s| vec![UNVISITED; s.slabs.len()]).collect(),
            nodes: Vec::with_capacity(shards.iter().map(|s| s.cubes.len() + s.inner.len()).sum()),
            slabs: Vec::with_capacity(shards.iter().map(|s| s.slabs.len()).sum()),
            shards,
        };
        let top = top
            .iter()
            .map(|root| match *root {
                NodeState::Lit => LIT,
                NodeState::Shadowed => SHADOWED,
                NodeState::Mixed(reference) => numbering.node(reference),
            })
            .collect();
        Dag { size, root_level, top_dims, top, nodes: numbering.nodes, slabs: numbering.slabs }
    }
}

struct Numbering {
    shards: Vec<Shard>,
    slab_numbers: Vec<Vec<u32>>,
    nodes: Vec<u32>,
    slabs: Vec<u64>,
}

impl Numbering {
    /// The number of a node, numbering it and all below it at the first visit. As deep as the tree has levels.
    fn node(&mut self, reference: u32) -> u32 {
        let Place { is_cube, shard, offset } = Place::of(reference);
        let from = &mut self.shards[shard];
        let stored = if is_cube { &mut from.cubes } else { &mut from.inner };
        if stored[offset] & COPIED != 0 {
            return stored[offset] & !COPIED;
        }
        let number = self.nodes.len() as u32;
        let mut children = children_at(stored, offset);
        stored[offset] = COPIED | number;
        let mut words = [0; 9];
        let length = encode(&children, &mut words);
        self.nodes.extend_from_slice(&words[..length]);
        for child in &mut children {
            if let NodeState::Mixed(r) = child {
                *r = if is_cube { self.slab(*r) } else { self.node(*r) };
            }
        }
        encode(&children, &mut words);
        self.nodes[number as usize..number as usize + length].copy_from_slice(&words[..length]);
        number
    }

    fn slab(&mut self, reference: u32) -> u32 {
        let (shard, index) = slab_place(reference);
        let number = &mut self.slab_numbers[shard][index];
        if *number == UNVISITED {
            *number = self.slabs.len() as u32;
            self.slabs.push(self.shards[shard].slabs[index]);
        }
        *number
    }
}
