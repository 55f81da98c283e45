//! The path of a look-up in a graph, which successive look-ups share.

use crate::dag::roots::MAX_ROOT_LEVEL;

/// The path of the most recent look-up in a graph, from which the next look-up starts.
#[derive(Clone, Copy, Debug)]
pub struct Trail {
    pub(super) voxel: [u32; 3],
    /// The visited node of each level, as far down as the path leads.
    pub(super) nodes: [u32; MAX_ROOT_LEVEL as usize + 1],
    /// Level of the lowest visited node, or [`NOWHERE`] if there is none.
    pub(super) lowest: u32,
    /// State of the cube of level `lowest - 1` at the end of the path, if it is all lit or all shadowed.
    pub(super) end: Option<bool>,
}

pub(super) const NOWHERE: u32 = u32::MAX;

impl Trail {
    /// Creates an empty trail.
    pub fn new() -> Self {
        Self { voxel: [0; 3], nodes: [0; MAX_ROOT_LEVEL as usize + 1], lowest: NOWHERE, end: None }
    }
}

impl Default for Trail {
    fn default() -> Self {
        Self::new()
    }
}
