//! One numbering for one graph: pre-order of first visit over the top grid, whatever order the nodes were made in.

use super::store::{
    MOST_WORDS, NodeState, NodeStore, Place, Shard, children_of, encode, node_length, slab_place,
};
use super::{Dag, LIT, SHADOWED};
use crate::paged::PagedVec;

const UNVISITED: u32 = u32::MAX;
/// Of a header in the store: the node has been copied, and the other bits are its number. Headers use 16 bits, numbers 31.
const COPIED: u32 = 1 << 31;

/// A numbered graph whose words may lie on disk; otherwise a [`Dag`].
pub(crate) struct PagedDag {
    pub(super) size: [u32; 3],
    pub(super) root_level: u32,
    pub(super) top_dims: [u32; 3],
    pub(super) top: Vec<u32>,
    pub(super) nodes: PagedVec<u32>,
    pub(super) slabs: PagedVec<u64>,
}

impl NodeStore {
    /// The finished graph under `top`, one root a cube of 2^`root_level` voxels, x fastest, then y, then z.
    ///
    /// Nodes that no root reaches are left behind. Cost: one visit a node; memory: the graph twice, without tables.
    pub fn finish(self, size: [u32; 3], root_level: u32, top_dims: [u32; 3], top: &[NodeState]) -> Dag {
        self.number(size, root_level, top_dims, top).into_dag()
    }

    /// The same, in pages of the store's spill, if it has one. Memory: four bytes a slab, and the spill's.
    pub(crate) fn number(
        self,
        size: [u32; 3],
        root_level: u32,
        top_dims: [u32; 3],
        top: &[NodeState],
    ) -> PagedDag {
        let (shards, spill) = self.into_shards();
        let mut numbering = Numbering {
            slab_numbers: shards.iter().map(|s| vec![UNVISITED; s.slabs.len()]).collect(),
            nodes: PagedVec::new(spill.as_ref()),
            slabs: PagedVec::new(spill.as_ref()),
            shards,
        };
        numbering.nodes.reserve_exact(numbering.shards.iter().map(|s| s.cubes.len() + s.inner.len()).sum());
        numbering.slabs.reserve_exact(numbering.shards.iter().map(|s| s.slabs.len()).sum());
        let top = top
            .iter()
            .map(|root| match *root {
                NodeState::Lit => LIT,
                NodeState::Shadowed => SHADOWED,
                NodeState::Mixed(reference) => numbering.node(reference),
            })
            .collect();
        let Numbering { nodes, slabs, .. } = numbering;
        PagedDag { size, root_level, top_dims, top, nodes, slabs }
    }
}

impl PagedDag {
    /// All of it in memory.
    pub(crate) fn into_dag(self) -> Dag {
        let Self { size, root_level, top_dims, top, nodes, slabs, .. } = self;
        Dag { size, root_level, top_dims, top, nodes: nodes.into_vec(), slabs: slabs.into_vec() }
    }

    /// Bytes of nodes and slabs.
    pub(crate) fn graph_bytes(&self) -> u64 {
        4 * self.nodes.len() as u64 + 8 * self.slabs.len() as u64
    }
}

struct Numbering {
    shards: Vec<Shard>,
    slab_numbers: Vec<Vec<u32>>,
    nodes: PagedVec<u32>,
    slabs: PagedVec<u64>,
}

impl Numbering {
    /// The number of a node, numbering it and all below it at the first visit. As deep as the tree has levels.
    fn node(&mut self, reference: u32) -> u32 {
        let Place { is_cube, shard, offset } = Place::of(reference);
        let from = &mut self.shards[shard];
        let stored = if is_cube { &mut from.cubes } else { &mut from.inner };
        let copied_length = |header| if header & COPIED != 0 { 1 } else { node_length(header) };
        let mut words = [0; MOST_WORDS];
        let length = stored.with::<MOST_WORDS, _>(offset, copied_length, |found| {
            words[..found.len()].copy_from_slice(found);
            found.len()
        });
        if words[0] & COPIED != 0 {
            return words[0] & !COPIED;
        }
        // What a failing disk has lost reads as zeros: nodes would not be known again.
        if self.nodes.has_failed() {
            return 0;
        }
        let number = self.nodes.len() as u32;
        let mut children = children_of(&words);
        stored.overwrite(offset, &[COPIED | number]);
        self.nodes.extend_from_slice(&words[..length]);
        for child in &mut children {
            if let NodeState::Mixed(r) = child {
                *r = if is_cube { self.slab(*r) } else { self.node(*r) };
            }
        }
        encode(&children, &mut words);
        self.nodes.overwrite(number as usize, &words[..length]);
        number
    }

    fn slab(&mut self, reference: u32) -> u32 {
        let (shard, index) = slab_place(reference);
        let number = &mut self.slab_numbers[shard][index];
        if *number == UNVISITED {
            *number = self.slabs.len() as u32;
            self.slabs.push(self.shards[shard].slabs.get(index));
        }
        *number
    }
}
