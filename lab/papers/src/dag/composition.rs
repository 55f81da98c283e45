//! Breakdown of a file's bytes.

/// Breakdown of the bytes of a file's voxels by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
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
