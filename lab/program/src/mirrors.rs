//! Schemas of the types of [`adumbra_papers`] that the program prints, as [`adumbra_program::mirrors`] has
//! those of the reader.
#![expect(dead_code, reason = "only their schemas are used")]

use adumbra_program::mirrors::{Bias, Bounds};
use schemars::JsonSchema;

/// How a file stores a graph.
#[derive(JsonSchema)]
#[schemars(rename_all = "lowercase")]
pub(crate) enum DagLayout {
    /// 32-bit headers and pointers.
    Plain,
    /// Units of 16 bits, in about a third of the bytes.
    Packed,
}

/// How a tree is built.
#[derive(JsonSchema)]
#[schemars(rename_all = "lowercase")]
pub(crate) enum TreeBuilder {
    /// A recursive function.
    Recursive,
    /// An explicit stack, one heap frame per push.
    Iterative,
    /// An explicit stack of frames that are reused.
    Pooled,
}

/// How equal subtrees are found.
#[derive(JsonSchema)]
#[schemars(rename_all = "kebab-case")]
pub(crate) enum Reduction {
    /// After the whole tree is built, by sorting height by height.
    Sort,
    /// While the tree is built, by a hash of the words of a block.
    Hash,
    /// While the tree is built, by the paper's tree hash (3-5, 3-6).
    TreeHash,
}

/// What a tree stores for each voxel of a leaf.
#[derive(JsonSchema)]
#[schemars(rename_all = "lowercase")]
pub(crate) enum AttributeKind {
    /// The width of the penumbra at the voxel.
    Penumbra,
}

/// What the bake of a tree took.
#[derive(JsonSchema)]
pub(crate) struct TreeReport {
    /// Total wall-clock time, seconds.
    seconds: f64,
    /// Seconds spent rendering the depth images and building their pyramids.
    image_seconds: f64,
    /// Seconds spent building, including the reduction if it runs during the build.
    build_seconds: f64,
    /// Seconds spent on the reduction after the build (sort) and on numbering.
    reduce_seconds: f64,
    /// Bytes of the depth images and their pyramids.
    image_bytes: u64,
    /// Peak bytes held by builder and reduction.
    held_bytes: u64,
    /// Number of blocks the builder produced: before the reduction if it sorts, after it if it hashes.
    built_blocks: u64,
    /// Number of comparisons of different subtrees with equal tree hashes.
    collisions: Option<u64>,
}

/// A region of a tree that has a depth of its own.
#[derive(JsonSchema)]
struct Region {
    /// World x range: from, to.
    x: [f64; 2],
    /// World z range: from, to.
    z: [f64; 2],
    /// Number of levels in the region.
    depth: u32,
}

/// The depth of a tree in each part of the plan: a base depth, and regions that are deeper. At each point the
/// deepest region that contains it counts.
#[derive(JsonSchema)]
pub(crate) struct Regions {
    /// Number of levels outside all regions.
    base_depth: u32,
    /// The deeper regions.
    list: Vec<Region>,
}

/// bias = slope factor · slope + constant (4-1), in texels of the light's depth image.
#[derive(JsonSchema)]
struct CaptureBias {
    /// The constant term.
    constant_texels: f64,
    /// Factor of the slope, which is the tangent of the angle between normal and light.
    slope_texels: f64,
}

/// The change allowed and made by a lossy merge: at most `max_share` times `leaf_voxels` voxels changed.
#[derive(JsonSchema)]
struct LossyChange {
    /// Maximum share of the leaf voxels that was allowed to change.
    max_share: f64,
    /// Number of leaf voxels of the tree before the merge: the cells of the leaves of eight in the expanded
    /// tree, each counted once whatever its size.
    leaf_voxels: u64,
    /// Number of voxels of the finest level that changed; a larger cell counts as all the voxels in it.
    changed_voxels: u64,
}

/// The settings of the bake of a tree.
#[derive(JsonSchema)]
pub(crate) struct TreeSettings {
    /// Whether the insides of closed components are free.
    closed_regions: bool,
    /// Whether alpha masks were ignored.
    ignore_alpha: bool,
    /// The box that determined the cube, if one was given.
    bounds: Option<Bounds>,
    /// The distance that depths were moved away from the light (4-1), in texels of the light's depth image.
    capture_bias: CaptureBias,
    /// The look-up bias, in voxels of the depth at the point.
    bias: Bias,
    /// The change made by a lossy merge, if there was one.
    lossy: Option<LossyChange>,
    /// Number of triangles baked, counted once per instance.
    triangles: u64,
    /// Number of instances baked.
    instances: u64,
}
