//! The interface through which look-ups read a tree in any encoding.

use crate::tree::graph::VoxelTree;
use crate::tree::symmetric;

/// A source of voxel visibility over a cube.
pub trait Voxels {
    /// Returns the visibility of voxel (x, y, z), each coordinate below the side of the cube.
    fn voxel(&self, xyz: [u32; 3]) -> bool {
        self.find(xyz).0
    }

    /// Returns the visibility of voxel (x, y, z) and the level of the cube that determines it, which has
    /// sides of 2^level voxels.
    fn find(&self, xyz: [u32; 3]) -> (bool, u32);
}

impl Voxels for VoxelTree {
    fn find(&self, xyz: [u32; 3]) -> (bool, u32) {
        Self::find(self, xyz)
    }
}

impl Voxels for symmetric::SymmetricTree {
    fn find(&self, xyz: [u32; 3]) -> (bool, u32) {
        Self::find(self, xyz)
    }
}
