//! What the bytes of a graph are spent on.

use serde::Serialize;

use super::Dag;

/// What the bytes of a graph are spent on, in either layout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Composition {
    /// Nodes.
    pub nodes: u64,
    /// Masks and planes of 64 bits, wherever they stand.
    pub slabs: u64,
    /// Bytes of the top grid.
    pub top_bytes: u64,
    /// Bytes of the nodes' headers.
    pub header_bytes: u64,
    /// Bytes of the nodes' pointers, to slabs too.
    pub pointer_bytes: u64,
    /// Bytes of masks and planes.
    pub slab_bytes: u64,
}

impl Dag {
    /// What the graph's bytes are spent on. Cost: one look at each header.
    pub fn composition(&self) -> Composition {
        let (nodes, slabs) = (self.node_count(), self.slabs.len() as u64);
        Composition {
            nodes,
            slabs,
            top_bytes: self.top.len() as u64 * 4,
            header_bytes: nodes * 4,
            pointer_bytes: (self.nodes.len() as u64 - nodes) * 4,
            slab_bytes: slabs * 8,
        }
    }
}
