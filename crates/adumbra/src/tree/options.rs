//! What the bake of a tree can be asked for.

use super::build::Builder;
use super::settings::CaptureBias;
use super::space::Region;
use crate::bake::Size;
use crate::light::Sun;
use crate::scene::Bounds;
use crate::settings::Bias;

/// How equal subtrees are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reduction {
    /// The whole tree first, then sorted height by height.
    Sort,
    /// While the tree is built, by a hash of a block's words.
    Hash,
    /// While the tree is built, by the paper's tree hash (3-5, 3-6).
    TreeHash,
}

/// Where the tree goes deeper than `--resolution` says.
#[derive(Clone, Debug, PartialEq)]
pub enum Detail {
    /// Nowhere.
    Uniform,
    /// In these regions; the size is that of the rest.
    Regions(Vec<Region>),
    /// In nested squares around a point: the size is that of the innermost, a level less in each next one.
    Rings {
        /// World x and z.
        center_xz: [f64; 2],
        /// Half sides, world units, innermost first.
        radii: Vec<f64>,
    },
}

/// Options of [`super::bake_tree`].
#[derive(Clone, Debug)]
pub struct TreeOptions {
    /// The sun.
    pub sun: Sun,
    /// Voxels a side of the cube, a power of two; or the voxel's edge.
    pub size: Size,
    /// Where it is finer.
    pub detail: Detail,
    /// Insides of closed components are free.
    pub closed_regions: bool,
    /// Take masked materials as opaque.
    pub ignore_alpha: bool,
    /// The cube is put around this box in place of the scene; casters outside it but sunward still cast into it.
    pub bounds: Option<Bounds>,
    /// How far depths are moved away from the light (4-1).
    pub capture_bias: CaptureBias,
    /// The look-up bias that the file asks for, in voxels.
    pub bias: Bias,
    /// Which builder.
    pub builder: Builder,
    /// Which reduction.
    pub reduction: Reduction,
    /// Whether cubes that the min/max pyramid decides are skipped. The tree is the same.
    pub prune: bool,
    /// Bytes that may be held; none = no limit.
    pub max_memory_bytes: Option<u64>,
}

impl TreeOptions {
    /// Defaults: pooled, by hash, pruned, closed regions used.
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
            builder: Builder::Pooled,
            reduction: Reduction::Hash,
            prune: true,
            max_memory_bytes: None,
        }
    }
}

/// The look-up bias of a tree, in voxels: a voxel is tested at its centre, which lies up to half a diagonal off.
/// A centre above the plane through the receiver needs half of (|nx| + |ny| + |nz|) / n·l, at most 0.87 (1 + slope).
pub const TREE_BIAS: Bias = Bias { constant_texels: 1.0, slope_texels: 0.75, normal_offset_texels: 0.0 };
