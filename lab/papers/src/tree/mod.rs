//! The world-aligned voxel tree of the 2021 paper: one bit per voxel, built top down and reduced to a graph,
//! with its file, its textures of words and its look-ups.
//!
//! Source: *The Optimization and realization of Compact Precomputed Voxelized Shadows Algorithm* (2021),
//! after Sintorn, Kämpe, Olsson, Assarsson, *Compact Precomputed Voxelized Shadows* (2014). Section and
//! equation numbers are those of the former.
//!
//! Stages of a bake: `layout` (the cube, and the columns of the light that each part needs) → `depth_image` →
//! `pyramid` → `lit_space` (tests voxel centres and cubes against them) → `build` → `reduce` →
//! `blocks` (canonical numbering) → [`VoxelTree`].
//!
//! | paper | topic | module |
//! |---|---|---|
//! | 2.2.1, (2-1), (2-2) | light camera, C · P · V | `light_camera` |
//! | 2.2.2 | depth image, only during the bake | `depth_image`, on `adumbra_bake::structure` |
//! | 2.2.3 | depth test at voxel centres | `lit_space`, in integers, so that a cube and its voxels cannot disagree |
//! | 3.1.1, (3-1) to (3-3) | Morton paths, both worked examples as tests | [`morton`] |
//! | 3.1.2, (3-4), Fig. 3-2 | the cube; upward merging | `space`; `build`, `join` |
//! | 3.1.3, Fig. 3-3 | closed regions: winding, not colliders | `depth_image`, `lit_space`; `adumbra_truth::picture` |
//! | 3.1.4, Fig. 3-4 | recursive, iterative, pooled | `build` |
//! | 3.2.1 | sort | [`reduce`] |
//! | 3.2.2, (3-5), (3-6), Fig. 3-5 | hash; the tree hash with its collisions counted | [`reduce`] |
//! | 3.3.1, (3-7) | 32-bit words | `word`, `graph`, `blocks`; `spec/adumbra-tree.md` |
//! | 3.3.2, 3.3.3 | words as an RGBA8 texture, and back | [`texture`] |
//! | 4.1.2, (4-1) | capture bias; look-up bias | `settings`, `depth_image`; [`query`] |
//! | 4.2.2 | voxel PCF, mean and Poisson weights | [`query`] |
//! | 5, Fig. 4-1 to 5-1 | pictures, counts of acne and leak | `adumbra-lab bench tree` |
//! | 1.3: LSVDAG | lossy merging, bounded and counted | [`lossy`] |
//! | 1.3: SSVDAG | mirrors, pointers of variable width | [`symmetric`] |
//! | 1.3: ESVDAG | a byte per leaf voxel, apart from the topology | [`attribute`]; [`PenumbraQuery`] |
//! | 6 | regions of several depths in one tree | `space` ([`Regions`]), `lit_space`, [`query`] |
//!
//! Departures from the paper:
//!
//! - A leaf of eight voxels is a mask in the block of its parent, so the lowest level needs no blocks. Such a
//!   leaf may be at any level.
//! - The builders take a [`Classify`], which decides cells and, where it can, whole cubes. Without the latter
//!   the builders are exhaustive. Both give the same tree (tested).
//! - Sorting proceeds by height above the leaves, so equal subtrees at different depths merge, as they do by
//!   hash.
//! - A free child whose siblings differ counts as shadowed: it is inside a solid.
//! - If the normal is known, taps of the voxel PCF behind the receiver's plane are skipped. `with_all_taps`
//!   filters as the paper does.
//! - A point below the cube has the visibility of the point where its sun ray enters the cube.
//! - The depth image has two texels per voxel edge up to depth 11, one beyond. Each region has a separate
//!   image over its part of the plan.
//! - If bounds are given, the cube is slightly larger than the box, so that points that the bias lifts beyond
//!   the rim of the box are inside it.

pub mod attribute;
mod bake;
mod blocks;
mod build;
mod depth_image;
mod error;
mod file;
mod graph;
#[cfg(test)]
mod kit;
mod layout;
mod leaf_voxels;
mod light;
mod light_camera;
mod lit_space;
pub mod lossy;
pub mod morton;
mod options;
mod page_limits;
mod picture;
mod pyramid;
pub mod query;
pub mod reduce;
mod settings;
mod space;
pub mod symmetric;
pub mod texture;
mod verify;
mod voxels;
mod word;

pub use bake::{BakedTree, PreparedTree, TreeProgress, TreeReport, bake_tree};
pub use blocks::{Blocks, MAX_BLOCKS};
pub use build::{Classify, State, TreeBuilder};
pub use error::{
    Error, LightTreeError, OptionError, Result, SymmetricError, TextureError, TreeError, TreeFileError,
    TreeOption, WordsError,
};
pub use file::{
    AttributeKind, TREE_HEADER_BYTES, TREE_MAGIC, TREE_VERSION, TreeBody, TreeFile, file_of_words, words_of,
};
pub use graph::VoxelTree;
pub use leaf_voxels::leaf_voxels;
pub use light::{dag_of_tree, tree_depth};
pub use light_camera::{LightCamera, Matrix};
pub use options::{Detail, Reduction, TREE_BIAS, TreeOptions};
pub use picture::{MAX_NODES_SIDE, nodes_by_size};
pub use query::{PenumbraQuery, TreeQuery, Weights};
pub use settings::{CaptureBias, LossyChange, TreeSettings};
pub use space::{MAX_REGIONS, Region, RegionVoxels, Regions, TreeSpace};
pub use verify::{TREE_PROMISES, TreeAnswers, volume_of};
pub use voxels::Voxels;
pub use word::{MAX_DEPTH, Node, Word};
