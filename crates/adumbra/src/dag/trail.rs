//! Ways down a graph, one after the other: what two neighbours have in common is walked once.

use super::{MAX_ROOT_LEVEL, SLAB_NODE_LEVEL};

/// The way to the place that was looked up last.
#[derive(Clone, Copy, Debug)]
pub struct Trail {
    voxel: [u32; 3],
    /// By level: the node that was met, where the way has led so far down.
    nodes: [u32; MAX_ROOT_LEVEL as usize + 1],
    /// Level of the lowest node that was met; [`NOWHERE`] for none.
    lowest: u32,
    /// What the cube of level `lowest - 1` at its end is, if it is all lit or all shadowed.
    end: Option<bool>,
}

const NOWHERE: u32 = u32::MAX;

impl Trail {
    /// A trail that leads nowhere yet.
    pub fn new() -> Self {
        Self { voxel: [0; 3], nodes: [0; MAX_ROOT_LEVEL as usize + 1], lowest: NOWHERE, end: None }
    }
}

impl Default for Trail {
    fn default() -> Self {
        Self::new()
    }
}

/// What one step down a graph finds.
#[derive(Clone, Copy)]
pub(super) enum Step {
    /// All lit or all shadowed.
    Uniform(bool),
    /// A node, at level 3 of the plain layout a slab.
    Into(u32),
}

/// A graph of cubes with slabs at its bottom, in either layout.
pub(super) trait Descend {
    fn root_level(&self) -> u32;

    /// The root cube that holds a voxel.
    fn root(&self, i: u32, j: u32, k: u32) -> Step;

    /// The child of a node above level 3 that holds a voxel.
    fn child(&self, node: u32, level: u32, i: u32, j: u32, k: u32) -> Step;

    /// The slab z = `k` of a node of level 3.
    fn slab_of_cube(&self, node: u32, k: u32) -> u64;

    /// The slab that holds a voxel.
    fn descend(&self, i: u32, j: u32, k: u32) -> u64 {
        let mut node = match self.root(i, j, k) {
            Step::Uniform(lit) => return uniform(lit),
            Step::Into(node) => node,
        };
        for level in (SLAB_NODE_LEVEL + 1..=self.root_level()).rev() {
            match self.child(node, level, i, j, k) {
                Step::Uniform(lit) => return uniform(lit),
                Step::Into(next) => node = next,
            }
        }
        self.slab_of_cube(node, k & 7)
    }

    /// Writes slab z = `k` of a node of level 3, and those that are known with it; which those are, as bits.
    fn fill_of_cube(&self, node: u32, k: u32, slabs: &mut [u64; 8]) -> u8 {
        slabs[k as usize] = self.slab_of_cube(node, k);
        1 << k
    }

    /// The node of level 3 that holds a voxel, or the larger cube that is all lit or all shadowed; from the lowest node on that the
    /// trail has in common with the voxel.
    fn follow(&self, trail: &mut Trail, i: u32, j: u32, k: u32) -> Step {
        let apart = (i ^ trail.voxel[0]) | (j ^ trail.voxel[1]) | (k ^ trail.voxel[2]);
        // The lowest level of which one cube holds both.
        let common = u32::BITS - apart.leading_zeros();
        let mut level = common.max(trail.lowest).max(SLAB_NODE_LEVEL);
        if trail.lowest == NOWHERE || common > self.root_level() {
            trail.lowest = NOWHERE;
            trail.end = None;
            match self.root(i, j, k) {
                Step::Uniform(lit) => return Step::Uniform(lit),
                Step::Into(node) => {
                    level = self.root_level();
                    trail.nodes[level as usize] = node;
                }
            }
        } else if let Some(lit) = trail.end
            && common < trail.lowest
        {
            return Step::Uniform(lit);
        }
        trail.voxel = [i, j, k];
        trail.end = None;
        let mut node = trail.nodes[level as usize];
        while level > SLAB_NODE_LEVEL {
            match self.child(node, level, i, j, k) {
                Step::Uniform(lit) => {
                    (trail.lowest, trail.end) = (level, Some(lit));
                    return Step::Uniform(lit);
                }
                Step::Into(next) => node = next,
            }
            level -= 1;
            trail.nodes[level as usize] = node;
        }
        trail.lowest = level;
        Step::Into(node)
    }

    /// [`Descend::descend`] along a trail.
    fn slab_on(&self, trail: &mut Trail, i: u32, j: u32, k: u32) -> u64 {
        match self.follow(trail, i, j, k) {
            Step::Uniform(lit) => uniform(lit),
            Step::Into(node) => self.slab_of_cube(node, k & 7),
        }
    }

    /// [`super::Slabs::fill_along`].
    fn fill_on(&self, trail: &mut Trail, [i, j, k]: [u32; 3], slabs: &mut [u64; 8]) -> u8 {
        match self.follow(trail, i, j, k) {
            Step::Uniform(lit) => {
                *slabs = [uniform(lit); 8];
                u8::MAX
            }
            Step::Into(node) => self.fill_of_cube(node, k & 7, slabs),
        }
    }

    /// Level of the block that answers a voxel: a uniform cube's, 3 for a uniform slab, 0 for a slab that is not.
    fn end_level(&self, i: u32, j: u32, k: u32) -> u32 {
        let Step::Into(mut node) = self.root(i, j, k) else { return self.root_level() };
        for level in (SLAB_NODE_LEVEL + 1..=self.root_level()).rev() {
            match self.child(node, level, i, j, k) {
                Step::Uniform(_) => return level - 1,
                Step::Into(next) => node = next,
            }
        }
        let is_uniform = matches!(self.slab_of_cube(node, k & 7), 0 | u64::MAX);
        if is_uniform { SLAB_NODE_LEVEL } else { 0 }
    }
}

pub(super) fn uniform(lit: bool) -> u64 {
    if lit { u64::MAX } else { 0 }
}
