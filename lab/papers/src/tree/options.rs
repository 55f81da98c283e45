//! Options for the bake of a tree.

use crate::tree::build::TreeBuilder;
use crate::tree::settings::CaptureBias;
use crate::tree::space::Region;
use adumbra::Bias;
use adumbra::grid::{Bounds, Sun};
use adumbra_bake::Size;

/// The method that finds equal subtrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reduction {
    /// After the whole tree is built, by sorting height by height.
    Sort,
    /// While the tree is built, by a hash of the words of a block.
    Hash,
    /// While the tree is built, by the paper's tree hash (3-5, 3-6).
    TreeHash,
}

/// Where the tree is deeper than its base resolution.
#[derive(Clone, Debug, PartialEq)]
pub enum Detail {
    /// Nowhere.
    Uniform,
    /// In these regions; the size is that of the rest of the tree.
    Regions(Vec<Region>),
    /// In nested squares around a point. The size is that of the innermost square; each further square has
    /// one level less.
    Rings {
        /// World x and z.
        center_xz: [f64; 2],
        /// Half sides in world units, innermost first.
        radii: Vec<f64>,
    },
}

/// Options of [`crate::tree::bake_tree`].
#[derive(Clone, Debug)]
pub struct TreeOptions {
    /// The sun that casts the shadows.
    pub sun: Sun,
    /// Number of voxels along a side of the cube, a power of two, or the edge of a voxel.
    pub size: Size,
    /// The parts of the tree that are finer.
    pub detail: Detail,
    /// Whether the insides of closed components are free.
    pub closed_regions: bool,
    /// Whether masked materials are treated as opaque.
    pub ignore_alpha: bool,
    /// Centres the cube on this box instead of on the scene. Casters outside the box but sunward of it still
    /// cast into it.
    pub bounds: Option<Bounds>,
    /// The distance that depths are moved away from the light (4-1).
    pub capture_bias: CaptureBias,
    /// The look-up bias stored in the file, in voxels.
    pub bias: Bias,
    /// The builder to use.
    pub builder: TreeBuilder,
    /// The reduction to use.
    pub reduction: Reduction,
    /// Whether cubes that the min/max pyramid decides are skipped. The resulting tree is the same.
    pub prune: bool,
    /// Maximum number of bytes to hold; `None` = no limit.
    pub max_memory_bytes: Option<u64>,
}

impl TreeOptions {
    /// Creates options with the defaults: pooled, by hash, pruned, with closed regions.
    pub fn new(sun: Sun, size: Size) -> Self {
        Self {
            sun,
            size,
            detail: Detail::Uniform,
            closed_regions: true,
            ignore_alpha: false,
            bounds: None,
            capture_bias: CaptureBias::default(),
            bias: TREE_BIAS,
            builder: TreeBuilder::Pooled,
            reduction: Reduction::Hash,
            prune: true,
            max_memory_bytes: None,
        }
    }
}

/// The look-up bias of a tree, in voxels. A voxel is tested at its centre, which is up to half a diagonal
/// away. A centre above the plane through the receiver needs a bias of half of (|nx| + |ny| + |nz|) / n·l, at
/// most 0.87 (1 + slope).
pub const TREE_BIAS: Bias = Bias { constant_texels: 1.0, slope_texels: 0.75, normal_offset_texels: 0.0 };
