//! Builds the plain graph of a function voxel -> lit, by visiting every voxel.

use std::collections::HashMap;

use adumbra_papers::dag::plain::{Dag, LIT, SHADOWED, STATE_LIT, STATE_MIXED, STATE_SHADOWED};
use adumbra_papers::dag::roots::{LEAF_NODE_LEVEL, top_dims};

use super::grids::Voxels;

/// A child before it has an index in the file: shadowed, lit, or an index into the merged nodes or leaf
/// masks.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Child {
    Shadowed,
    Lit,
    Mixed(usize),
}

/// Merges equal nodes and leaf masks while it builds.
struct GraphMerger<'a> {
    lit: &'a Voxels,
    /// Size of the grid. Voxels outside are never looked up: those to the sides count as lit, those behind
    /// the far end as shadowed.
    size: [u32; 3],
    nodes: Vec<[Child; 8]>,
    leaf_masks: Vec<u64>,
    /// Keyed by whether the children are leaf masks, and by the children: a node without leaf masks below may
    /// be used at several levels.
    node_ids: HashMap<(bool, [Child; 8]), usize>,
    leaf_mask_ids: HashMap<u64, usize>,
}

/// Returns the graph of the voxels of a grid, with equal nodes and leaf masks stored once.
pub(super) fn build(size: [u32; 3], root_level: u32, lit: &Voxels) -> Dag {
    let (node_ids, leaf_mask_ids) = (HashMap::new(), HashMap::new());
    let mut builder =
        GraphMerger { lit, size, nodes: Vec::new(), leaf_masks: Vec::new(), node_ids, leaf_mask_ids };
    let top_dims = top_dims(size, root_level);
    let mut dag = Dag { size, root_level, top_dims, ..Dag::default() };
    let mut roots = Vec::new();
    for gz in 0..top_dims[2] {
        for gy in 0..top_dims[1] {
            for gx in 0..top_dims[0] {
                roots.push(builder.node([gx, gy, gz].map(|g| g << root_level), root_level));
            }
        }
    }
    let mut placed = Placed { nodes: HashMap::new(), leaf_masks: HashMap::new() };
    for root in roots {
        let entry = match root {
            Child::Shadowed => SHADOWED,
            Child::Lit => LIT,
            Child::Mixed(id) => placed.node(&builder, &mut dag, id, root_level),
        };
        dag.top.push(entry);
    }
    dag
}

impl GraphMerger<'_> {
    fn node(&mut self, at: [u32; 3], level: u32) -> Child {
        if (0..2).any(|a| at[a] >= self.size[a]) {
            return Child::Lit;
        }
        if at[2] >= self.size[2] {
            return Child::Shadowed;
        }
        let mut children = [Child::Lit; 8];
        for (c, child) in (0_u32..).zip(&mut children) {
            *child = if level == LEAF_NODE_LEVEL {
                self.leaf_mask([at[0], at[1], at[2] + c])
            } else {
                let half = level - 1;
                let bits = [c >> 2, c >> 1 & 1, c & 1];
                self.node([0, 1, 2].map(|a| at[a] + (bits[a] << half)), half)
            };
        }
        if !matches!(children[0], Child::Mixed(_)) && children.iter().all(|c| *c == children[0]) {
            return children[0];
        }
        let next = self.nodes.len();
        let id = *self.node_ids.entry((level == LEAF_NODE_LEVEL, children)).or_insert(next);
        if id == next {
            self.nodes.push(children);
        }
        Child::Mixed(id)
    }

    fn leaf_mask(&mut self, at: [u32; 3]) -> Child {
        let mask = (0..64_u32).fold(0_u64, |mask, bit| {
            let v = [at[0] + bit % 8, at[1] + bit / 8, at[2]];
            let beside = (0..2).any(|a| v[a] >= self.size[a]);
            mask | u64::from(beside || v[2] < self.size[2] && (self.lit)(v[0], v[1], v[2])) << bit
        });
        match mask {
            0 => Child::Shadowed,
            u64::MAX => Child::Lit,
            _ => {
                let next = self.leaf_masks.len();
                let id = *self.leaf_mask_ids.entry(mask).or_insert(next);
                if id == next {
                    self.leaf_masks.push(mask);
                }
                Child::Mixed(id)
            }
        }
    }
}

/// Indices in the file, in order of first visit.
struct Placed {
    nodes: HashMap<usize, u32>,
    leaf_masks: HashMap<usize, u32>,
}

impl Placed {
    fn node(&mut self, from: &GraphMerger<'_>, dag: &mut Dag, id: usize, level: u32) -> u32 {
        if let Some(&at) = self.nodes.get(&id) {
            return at;
        }
        let at = dag.nodes.len();
        self.nodes.insert(id, at as u32);
        let children = from.nodes[id];
        let states = children.map(|c| match c {
            Child::Shadowed => STATE_SHADOWED,
            Child::Lit => STATE_LIT,
            Child::Mixed(_) => STATE_MIXED,
        });
        dag.nodes.push(states.iter().rev().fold(0, |header, s| header << 2 | s));
        let mixed: Vec<usize> =
            children.iter().filter_map(|c| if let Child::Mixed(id) = c { Some(*id) } else { None }).collect();
        dag.nodes.resize(at + 1 + mixed.len(), 0);
        for (i, child) in mixed.into_iter().enumerate() {
            dag.nodes[at + 1 + i] = if level == LEAF_NODE_LEVEL {
                *self.leaf_masks.entry(child).or_insert_with(|| {
                    dag.leaf_masks.push(from.leaf_masks[child]);
                    dag.leaf_masks.len() as u32 - 1
                })
            } else {
                self.node(from, dag, child, level - 1)
            };
        }
        at as u32
    }
}
