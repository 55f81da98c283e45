//! The trait through which look-ups read a graph, and with it a quadtree, so that both can be compared.

use super::trail::Trail;

/// A structure that looks up leaf masks of 8 × 8 × 1 voxels of a light-aligned grid.
pub trait LeafMasks: Sync {
    /// Returns the number of voxels along x, y, z.
    fn size(&self) -> [u32; 3];

    /// Returns the leaf mask that contains voxel (i, j, k): bit y·8 + x, 1 = lit. The voxel must be in the
    /// grid.
    fn look_up(&self, i: u32, j: u32, k: u32) -> u64;

    /// Returns whether voxel (i, j, k) is lit. The voxel must be in the grid.
    fn voxel(&self, i: u32, j: u32, k: u32) -> bool {
        self.look_up(i, j, k) >> ((j & 7) * 8 + (i & 7)) & 1 == 1
    }

    /// Returns the level of the block in which a look-up of voxel (i, j, k) ends. The voxel must be in the
    /// grid.
    ///
    /// The block is all lit or all shadowed and spans 2^level voxels along each side. Level 3 is also
    /// returned for a uniform leaf mask of 8 × 8 × 1 voxels. Level 0 is a single voxel or a single column.
    fn end_level(&self, i: u32, j: u32, k: u32) -> u32;

    /// Returns the leaf mask that contains voxel (i, j, k), like [`LeafMasks::look_up`], starting from the
    /// previous look-up of this `trail`. This is cheap if both look-ups share most of their path. A trail
    /// must only be used with one structure.
    fn look_up_with(&self, _trail: &mut Trail, i: u32, j: u32, k: u32) -> u64 {
        self.look_up(i, j, k)
    }

    /// Fills in leaf masks of the cube of 8 × 8 × 8 voxels that contains voxel (i, j, k), nearest to the sun
    /// first.
    ///
    /// Writes the leaf mask that contains the voxel to its index in the cube, together with those that are
    /// known at no further cost. Returns which were written, as bits.
    fn fill(&self, trail: &mut Trail, [i, j, k]: [u32; 3], leaf_masks: &mut [u64; 8]) -> u8 {
        leaf_masks[(k & 7) as usize] = self.look_up_with(trail, i, j, k);
        1 << (k & 7)
    }
}
