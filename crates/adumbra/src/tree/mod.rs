//! The paper's voxel tree: world-aligned, one bit a voxel, built top down, reduced to a graph.
//!
//! Source: *The Optimization and realization of Compact Precomputed Voxelized Shadows Algorithm* (2021), a realisation
//! of Sintorn, Kämpe, Olsson, Assarsson, *Compact Precomputed Voxelized Shadows* (2014). Section and equation numbers are
//! the former's.

pub mod attribute;
mod bake;
mod blocks;
mod build;
mod depth_image;
mod graph;
#[cfg(test)]
mod kit;
mod layout;
mod leaf_voxels;
mod light;
mod lit_space;
pub mod lossy;
pub mod morton;
mod options;
mod pyramid;
pub mod reduce;
mod settings;
mod space;
pub mod symmetric;
mod word;

pub use bake::{BakedTree, PreparedTree, TreeProgress, TreeReport, bake_tree};
pub use blocks::{Blocks, MAX_BLOCKS};
pub use build::{Builder, Classify, State};
pub(crate) use graph::check as check_words;
pub use graph::{MAX_DEPTH, TreeError, VoxelTree};
pub use leaf_voxels::leaf_voxels;
pub use light::{LightTreeError, MAX_ROOTS, dag_of_tree, tree_depth};
pub use options::{Detail, Reduction, TREE_BIAS, TreeOptions};
pub use settings::{CaptureBias, LossyChange, TreeSettings};
pub use space::{MAX_REGIONS, Region, RegionVoxels, Regions, TreeSpace};
pub use word::{Node, Word};

/// What answers voxels of a cube.
pub trait Voxels {
    /// Visibility of voxel (x, y, z), each below the cube's side.
    fn voxel(&self, xyz: [u32; 3]) -> bool {
        self.find(xyz).0
    }

    /// The same, and the level of the cube that says so: it spans 2^level voxels a side.
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
