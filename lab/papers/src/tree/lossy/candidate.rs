//! A pair of similar blocks.

/// A merge of `source` into `target` that could be made.
#[derive(Clone, Copy)]
pub(crate) struct Candidate {
    pub(crate) source: u32,
    pub(crate) target: u32,
    /// Number of voxels that change.
    pub(crate) cost: u64,
}
