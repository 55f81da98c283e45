//! All results of `bench tree`: one part per section, kept when a later run measures only other sections.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The whole file.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub(crate) struct TreeResults {
    /// Section `builders`; `None` if it was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) builders: Option<Part<Vec<BuilderRow>>>,
    /// Section `reductions`; `None` if it was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) reductions: Option<Part<Vec<ReductionRow>>>,
    /// Section `frames`; `None` if it was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) frames: Option<Part<FrameRows>>,
    /// Section `options`; `None` if it was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) options: Option<Part<Vec<OptionRow>>>,
    /// Section `filters`; `None` if it was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) filters: Option<Part<Vec<FilterRow>>>,
}

/// One section.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "PartOf{R}")]
pub(crate) struct Part<R> {
    /// Number of runs that each median is taken over.
    pub(crate) runs: usize,
    /// Number of points compared with rays.
    pub(crate) samples: u64,
    /// Threads.
    pub(crate) threads: usize,
    /// One row per measurement.
    pub(crate) rows: R,
}

/// One value per builder.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "ByBuilder_{T}")]
pub(crate) struct ByBuilder<T> {
    /// Of the recursive builder.
    pub(crate) recursive: T,
    /// Of the iterative builder.
    pub(crate) iterative: T,
    /// Of the pooled builder.
    pub(crate) pooled: T,
}

impl<T> ByBuilder<T> {
    /// Returns the values in the order recursive, iterative, pooled.
    pub(crate) fn list(self) -> [T; 3] {
        [self.recursive, self.iterative, self.pooled]
    }
}

/// One value per reduction.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "ByReduction_{T}")]
pub(crate) struct ByReduction<T> {
    /// Of the reduction by sorting.
    pub(crate) sort: T,
    /// Of the reduction by hashing.
    pub(crate) hash: T,
    /// Of the reduction by tree hashes.
    pub(crate) tree_hash: T,
}

/// The builders' results on a scene at one depth.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct BuilderRow {
    /// Name of the scene.
    pub(crate) scene: String,
    /// Levels of the tree: 2^depth voxels per side.
    pub(crate) depth: u32,
    /// Whether cubes that the min/max pyramid decides are skipped.
    pub(crate) pruned: bool,
    /// Whether all builders made the same graph.
    pub(crate) agree: bool,
    /// Wall time in seconds, the median of the runs.
    pub(crate) seconds: ByBuilder<f64>,
    /// Largest resident size of the whole process; `None` if the system does not report it.
    pub(crate) peak_bytes: ByBuilder<Option<u64>>,
    /// Seconds that the depth images take.
    pub(crate) image_seconds: f64,
    /// Size of the depth images and their pyramids.
    pub(crate) image_bytes: u64,
}

/// The reductions' results on a scene at one depth.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct ReductionRow {
    /// Name of the scene.
    pub(crate) scene: String,
    /// Levels of the tree: 2^depth voxels per side.
    pub(crate) depth: u32,
    /// Whether all reductions made the same graph.
    pub(crate) agree: bool,
    /// Wall time in seconds, the median of the runs.
    pub(crate) seconds: ByReduction<f64>,
    /// Largest size of tree, tables and keys together.
    pub(crate) held_bytes: ByReduction<u64>,
    /// Largest resident size of the whole process; `None` if the system does not report it.
    pub(crate) peak_bytes: ByReduction<Option<u64>>,
    /// Comparisons of different subtrees with equal tree hashes; `None` if they were not counted.
    pub(crate) collisions: Option<u64>,
    /// Size of the complete tree.
    pub(crate) complete_bytes: f64,
    /// Size of the tree after uniform subtrees were merged.
    pub(crate) merged_bytes: u64,
    /// Size of the graph, in which equal subtrees are shared.
    pub(crate) graph_bytes: u64,
}

impl ReductionRow {
    /// Returns the merged tree's size as a share of the complete tree's.
    pub(crate) fn merged_share(&self) -> f64 {
        self.merged_bytes as f64 / self.complete_bytes
    }

    /// Returns the graph's size as a share of the merged tree's.
    pub(crate) fn shared_share(&self) -> f64 {
        self.graph_bytes as f64 / self.merged_bytes as f64
    }
}

/// The rows of both tables of the section on frames.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct FrameRows {
    /// One row per scene, depth and frame.
    pub(crate) frames: Vec<FrameRow>,
    /// Tree sizes with and without closed regions.
    pub(crate) closed_regions: Vec<ClosedRow>,
}

/// A frame's results on a scene at one depth.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct FrameRow {
    /// Name of the scene.
    pub(crate) scene: String,
    /// Levels of the tree: 2^depth voxels per side.
    pub(crate) depth: u32,
    /// Alignment: `world` or `light`.
    pub(crate) frame: String,
    /// Edge of a voxel in world units.
    pub(crate) voxel_size: f64,
    /// Size of the file.
    pub(crate) bytes: u64,
    /// Wall time in seconds, the median of the runs.
    pub(crate) seconds: f64,
    /// Agreement with rays.
    pub(crate) agreement: f64,
    /// Agreement with rays of the points away from edges.
    pub(crate) interior_agreement: f64,
    /// Share of the points that are lit but called shadowed.
    pub(crate) acne: f64,
    /// Share of the points that are shadowed but called lit.
    pub(crate) leak: f64,
}

/// Tree sizes of a scene with or without closed regions.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct ClosedRow {
    /// Name of the scene.
    pub(crate) scene: String,
    /// Levels of the tree: 2^depth voxels per side.
    pub(crate) depth: u32,
    /// Whether closed regions are filled.
    pub(crate) closed_regions: bool,
    /// Size of the tree after uniform subtrees were merged.
    pub(crate) merged_bytes: u64,
    /// Size of the graph, in which equal subtrees are shared.
    pub(crate) graph_bytes: u64,
}

/// An option's results on a scene.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct OptionRow {
    /// Name of the scene.
    pub(crate) scene: String,
    /// Levels of the tree: 2^depth voxels per side.
    pub(crate) depth: u32,
    /// Option that differs from the defaults.
    pub(crate) option: String,
    /// Size of the file.
    pub(crate) bytes: u64,
    /// Size divided by that of the tree in plain words.
    pub(crate) times_plain: f64,
    /// Wall time in seconds, the median of the runs.
    pub(crate) seconds: f64,
    /// Voxels that differ from the plain tree; `None` if the option changes none.
    pub(crate) changed_voxels: Option<u64>,
    /// Voxels at shadow borders; `None` if the option changes none.
    pub(crate) leaf_voxels: Option<u64>,
    /// Time per look-up.
    pub(crate) nanoseconds: f64,
}

/// A look-up variant's results on a scene.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct FilterRow {
    /// Name of the scene.
    pub(crate) scene: String,
    /// Levels of the tree: 2^depth voxels per side.
    pub(crate) depth: u32,
    /// How points are looked up.
    pub(crate) look_up: String,
    /// Agreement with rays.
    pub(crate) agreement: f64,
    /// Share of the points that are lit but called shadowed.
    pub(crate) acne: f64,
    /// Share of the points that are shadowed but called lit.
    pub(crate) leak: f64,
    /// Number of interior points, which are two voxels away from any outline.
    pub(crate) interior: u64,
    /// Interior points that are lit but called shadowed.
    pub(crate) interior_acne: u64,
    /// Interior points that are shadowed but called lit.
    pub(crate) interior_leak: u64,
}
