//! One numbering for one graph: pre-order of first visit over the top grid, whatever order the nodes were made in.

use super::store::{NodeState, NodeStore, encode};
use super::{Dag, LIT, SHADOWED};

const UNVISITED: u32 = u32::MAX;

impl NodeStore {
    /// The finished graph under `top`, one root a cube of 2^`root_level` voxels, x fastest, then y, then z.
    ///
    /// Nodes that no root reaches are left behind. Cost: one visit a node; memory: a word a word.
    pub fn finish(&self, size: [u32; 3], root_level: u32, top_dims: [u32; 3], top: &[NodeState]) -> Dag {
        let mut numbering = Numbering {
            store: self,
            slab_numbers: vec![UNVISITED; self.slabs.len()],
            cube_numbers: vec![UNVISITED; self.cubes.len()],
            inner_numbers: vec![UNVISITED; self.inner.len()],
            nodes: Vec::with_capacity(self.cubes.len() + self.inner.len()),
            slabs: Vec::with_capacity(self.slabs.len()),
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

struct Numbering<'s> {
    store: &'s NodeStore,
    slab_numbers: Vec<u32>,
    cube_numbers: Vec<u32>,
    inner_numbers: Vec<u32>,
    nodes: Vec<u32>,
    slabs: Vec<u64>,
}

impl Numbering<'_> {
    /// The number of a node, numbering it and all below it at the first visit. As deep as the tree has levels.
    fn node(&mut self, reference: u32) -> u32 {
        let (is_cube, mut children) = self.store.children(reference);
        let offset = NodeStore::word_offset(reference);
        let numbers = if is_cube { &mut self.cube_numbers } else { &mut self.inner_numbers };
        if numbers[offset] != UNVISITED {
            return numbers[offset];
        }
        let number = self.nodes.len() as u32;
        numbers[offset] = number;
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

    fn slab(&mut self, index: u32) -> u32 {
        let number = &mut self.slab_numbers[index as usize];
        if *number == UNVISITED {
            *number = self.slabs.len() as u32;
            self.slabs.push(self.store.slabs[index as usize]);
        }
        *number
    }
}
