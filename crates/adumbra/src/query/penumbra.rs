//! The penumbra's width at a point, from the bytes that a tree keeps beside its voxels.

use super::TreeQuery;
use crate::error::Result;
use crate::tree::VoxelTree;
use crate::tree::attribute::AttributeIndex;

/// A look-up of penumbra widths.
#[derive(Debug)]
pub struct PenumbraQuery<'t> {
    query: TreeQuery<'t, VoxelTree>,
    tree: &'t VoxelTree,
    index: AttributeIndex,
    eighths: &'t [u8],
}

impl<'t> PenumbraQuery<'t> {
    /// `eighths` are the bytes kept for `tree`, the one that `query` looks up. Cost: one walk over the graph, four bytes
    /// a word.
    ///
    /// # Errors
    /// A tree of 2^32 leaf voxels or more.
    pub fn new(query: TreeQuery<'t, VoxelTree>, tree: &'t VoxelTree, eighths: &'t [u8]) -> Result<Self> {
        Ok(Self { query, tree, index: AttributeIndex::of(tree)?, eighths })
    }

    /// Width of the sun's penumbra in world units where a shadow's border passes the voxel that answers this point; none
    /// elsewhere.
    pub fn width(&self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> Option<f64> {
        let voxel = self.query.voxel_at(p_world, normal)?;
        let eighths = *self.eighths.get(self.index.locate(self.tree, voxel)? as usize)?;
        Some(f64::from(eighths) / 8.0 * self.query.space().voxel_size)
    }
}
