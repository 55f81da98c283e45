//! One numbering for one graph: pre-order of first visit over the top grid, whatever order the nodes were made in.

use super::store::{NodeState, NodeStore, Place, Shard, children_at, encode, slab_place};
use super::{Dag, LIT, SHADOWED};

const UNVISITED: u32 = u32::MAX;

impl NodeStore {
    /// The finished graph under `top`, one root a cube of 2^`root_level` voxels, x fastest, then y, then z.
    ///
    /// Nodes that no root reaches are left behind. Cost: one visit a node; memory: a word a word.
    pub fn finish(self, size: [u32; 3], root_level: u32, top_dims: [u32; 3], top: &[NodeState]) -> Dag {
        let shards = self.into_shards();
        let unvisited = |length: fn(&Shard) -> usize| -> Vec<Vec<u32>> {
            shards.iter().map(|s| vec![UNVISITED; length(s)]).collect()
        };
        let mut numbering = Numbering {
            slab_numbers: unvisited(|s| s.slabs.len()),
            cube_numbers: unvisited(|s| s.cubes.len()),
            inner_numbers: unvisited(|s| s.inner.len()),
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
    cube_numbers: Vec<Vec<u32>>,
    inner_numbers: Vec<Vec<u32>>,
    nodes: Vec<u32>,
    slabs: Vec<u64>,
}

impl Numbering {
    /// The number of a node, numbering it and all below it at the first visit. As deep as the tree has levels.
    fn node(&mut self, reference: u32) -> u32 {
        let Place { is_cube, shard, offset } = Place::of(reference);
        let numbers = if is_cube { &mut self.cube_numbers[shard] } else { &mut self.inner_numbers[shard] };
        if numbers[offset] != UNVISITED {
            return numbers[offset];
        }
        let number = self.nodes.len() as u32;
        numbers[offset] = number;
        let words = if is_cube { &self.shards[shard].cubes } else { &self.shards[shard].inner };
        let mut children = children_at(words, offset);
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
