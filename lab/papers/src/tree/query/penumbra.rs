//! Looks up the width of the penumbra at a point, from the attribute bytes of a tree.

use crate::tree::attribute::AttributeIndex;
use crate::tree::error::Result;
use crate::tree::graph::VoxelTree;
use crate::tree::query::TreeQuery;

/// Look-ups of penumbra widths.
#[derive(Debug)]
pub struct PenumbraQuery<'t> {
    query: TreeQuery<'t, VoxelTree>,
    tree: &'t VoxelTree,
    index: AttributeIndex,
    eighths: &'t [u8],
}

impl<'t> PenumbraQuery<'t> {
    /// `eighths` are the attribute bytes of `tree`, which must be the tree that `query` looks up. Cost: one
    /// walk over the graph, four bytes per word.
    ///
    /// # Errors
    /// Returns an error if the tree has 2^32 leaf voxels or more.
    pub fn new(query: TreeQuery<'t, VoxelTree>, tree: &'t VoxelTree, eighths: &'t [u8]) -> Result<Self> {
        Ok(Self { query, tree, index: AttributeIndex::of(tree)?, eighths })
    }

    /// Returns the width of the sun's penumbra in world units if a shadow border passes through the voxel
    /// that answers this point, else `None`.
    pub fn width(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> Option<f64> {
        let voxel = self.query.voxel_at(p_world, normal)?;
        let eighths = *self.eighths.get(self.index.locate(self.tree, voxel)? as usize)?;
        Some(f64::from(eighths) / 8.0 * self.query.space().voxel_size)
    }
}
