//! Breakdown of a graph's bytes.

use crate::layout::plain::Dag;

/// Breakdown of a graph's bytes by kind, for the layouts `plain` and `packed`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Composition {
    /// Number of nodes.
    pub nodes: u64,
    /// Number of masks and bit planes of 64 bits, both shared ones and those inside nodes.
    pub leaf_masks: u64,
    /// Bytes of the top grid.
    pub top_bytes: u64,
    /// Bytes of the nodes' headers.
    pub header_bytes: u64,
    /// Bytes of the nodes' pointers, including those to leaf masks.
    pub pointer_bytes: u64,
    /// Bytes of masks and bit planes.
    pub leaf_mask_bytes: u64,
}

impl Dag {
    /// Returns the breakdown of the graph's bytes. Cost: one read of each header.
    pub fn composition(&self) -> Composition {
        let (nodes, leaf_masks) = (self.node_count(), self.leaf_masks.len() as u64);
        Composition {
            nodes,
            leaf_masks,
            top_bytes: self.top.len() as u64 * 4,
            header_bytes: nodes * 4,
            pointer_bytes: (self.nodes.len() as u64 - nodes) * 4,
            leaf_mask_bytes: leaf_masks * 8,
        }
    }
}
