//! Traversals of a graph in any layout. Successive look-ups walk the path that they share only once.

use crate::dag::roots::LEAF_NODE_LEVEL;

use crate::dag::LeafMasks;
use crate::dag::trail::{NOWHERE, Trail};

/// Result of one step down a graph.
#[derive(Clone, Copy)]
pub(super) enum Descent {
    /// All lit (true) or all shadowed (false).
    Uniform(bool),
    /// A node; below level 3 of the plain layout, a leaf mask.
    Into(u32),
}

/// A graph of cubes with leaf masks at the bottom, in the layout `plain` or `packed`.
pub(super) trait Descend: Sync {
    fn size(&self) -> [u32; 3];

    fn root_level(&self) -> u32;

    /// Returns the root cube that contains a voxel.
    fn root(&self, i: u32, j: u32, k: u32) -> Descent;

    /// Returns the child of a node above level 3 that contains a voxel.
    fn child(&self, node: u32, level: u32, i: u32, j: u32, k: u32) -> Descent;

    /// Returns the leaf mask z = `k` of a node of level 3.
    fn leaf_mask_of_cube(&self, node: u32, k: u32) -> u64;

    /// Writes leaf mask z = `k` of a node of level 3, and all leaf masks that are known at no further cost.
    /// Returns a bit mask of those written.
    fn fill_of_cube(&self, node: u32, k: u32, leaf_masks: &mut [u64; 8]) -> u8 {
        leaf_masks[k as usize] = self.leaf_mask_of_cube(node, k);
        1 << k
    }

    /// Returns the node of level 3 that contains a voxel, or the state of the larger cube if that is all lit
    /// or all shadowed. Starts at the lowest node that the trail shares with the voxel.
    fn follow(&self, trail: &mut Trail, i: u32, j: u32, k: u32) -> Descent {
        let apart = (i ^ trail.voxel[0]) | (j ^ trail.voxel[1]) | (k ^ trail.voxel[2]);
        // The lowest level at which one cube contains both voxels.
        let common = u32::BITS - apart.leading_zeros();
        let mut level = common.max(trail.lowest).max(LEAF_NODE_LEVEL);
        if trail.lowest == NOWHERE || common > self.root_level() {
            trail.lowest = NOWHERE;
            trail.end = None;
            match self.root(i, j, k) {
                Descent::Uniform(lit) => return Descent::Uniform(lit),
                Descent::Into(node) => {
                    level = self.root_level();
                    trail.nodes[level as usize] = node;
                }
            }
        } else if let Some(lit) = trail.end
            && common < trail.lowest
        {
            return Descent::Uniform(lit);
        }
        trail.voxel = [i, j, k];
        trail.end = None;
        let mut node = trail.nodes[level as usize];
        while level > LEAF_NODE_LEVEL {
            match self.child(node, level, i, j, k) {
                Descent::Uniform(lit) => {
                    (trail.lowest, trail.end) = (level, Some(lit));
                    return Descent::Uniform(lit);
                }
                Descent::Into(next) => node = next,
            }
            level -= 1;
            trail.nodes[level as usize] = node;
        }
        trail.lowest = level;
        Descent::Into(node)
    }
}

impl<G: Descend> LeafMasks for G {
    fn size(&self) -> [u32; 3] {
        Descend::size(self)
    }

    fn look_up(&self, i: u32, j: u32, k: u32) -> u64 {
        let mut node = match self.root(i, j, k) {
            Descent::Uniform(lit) => return uniform(lit),
            Descent::Into(node) => node,
        };
        for level in (LEAF_NODE_LEVEL + 1..=self.root_level()).rev() {
            match self.child(node, level, i, j, k) {
                Descent::Uniform(lit) => return uniform(lit),
                Descent::Into(next) => node = next,
            }
        }
        self.leaf_mask_of_cube(node, k & 7)
    }

    fn end_level(&self, i: u32, j: u32, k: u32) -> u32 {
        let Descent::Into(mut node) = self.root(i, j, k) else { return self.root_level() };
        for level in (LEAF_NODE_LEVEL + 1..=self.root_level()).rev() {
            match self.child(node, level, i, j, k) {
                Descent::Uniform(_) => return level - 1,
                Descent::Into(next) => node = next,
            }
        }
        let is_uniform = matches!(self.leaf_mask_of_cube(node, k & 7), 0 | u64::MAX);
        if is_uniform { LEAF_NODE_LEVEL } else { 0 }
    }

    fn look_up_with(&self, trail: &mut Trail, i: u32, j: u32, k: u32) -> u64 {
        match self.follow(trail, i, j, k) {
            Descent::Uniform(lit) => uniform(lit),
            Descent::Into(node) => self.leaf_mask_of_cube(node, k & 7),
        }
    }

    fn fill(&self, trail: &mut Trail, [i, j, k]: [u32; 3], leaf_masks: &mut [u64; 8]) -> u8 {
        match self.follow(trail, i, j, k) {
            Descent::Uniform(lit) => {
                *leaf_masks = [uniform(lit); 8];
                u8::MAX
            }
            Descent::Into(node) => self.fill_of_cube(node, k & 7, leaf_masks),
        }
    }
}

pub(super) fn uniform(lit: bool) -> u64 {
    if lit { u64::MAX } else { 0 }
}
