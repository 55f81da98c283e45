//! The paper's voxel tree: world-aligned, one bit a voxel, built top down, reduced to a graph.
//!
//! Source: *The Optimization and realization of Compact Precomputed Voxelized Shadows Algorithm* (2021), a realisation
//! of Sintorn, Kämpe, Olsson, Assarsson, *Compact Precomputed Voxelized Shadows* (2014). Section and equation numbers are
//! the former's.

mod blocks;
mod build;
mod graph;
mod light;
pub mod morton;
pub mod reduce;
mod settings;
mod space;
mod word;

pub use blocks::{Blocks, MAX_BLOCKS};
pub use build::{Builder, Classify, State};
pub use graph::{MAX_DEPTH, TreeError, VoxelTree};
pub use light::{LightTreeError, MAX_ROOTS, dag_of_tree, tree_depth};
pub use settings::{CaptureBias, LossyChange, TreeSettings};
pub use space::{MAX_REGIONS, Region, Regions, TreeSpace};
pub use word::{Node, Word};
