//! The shaders of the papers: the files of `wgsl/`, and the constants and structures that they share with
//! Rust.

use std::sync::LazyLock;

use adumbra_shaders::Source;
use adumbra_shaders::gpu_struct;
use adumbra_shaders::layout::{Array, GridTransform, ReceiverBias, StructInfo};

use crate::dag::{packed, plain};
use crate::tree::query::{MAX_HEIGHT_CELLS, NORMAL_ONE};

/// Largest number of regions with different depths that a tree's look-up supports.
pub const MAX_PLAN_REGIONS: u32 = 16;

gpu_struct! {
    /// A baked world-aligned tree.
    pub struct CubesParams {
        /// Position of the tree's cube; its axes are the world's.
        pub grid: GridTransform,
        /// Unit vector towards the sun used for the bake.
        pub towards_sun: [f32; 3],
        /// Bias applied to the receiver; its texels are cells.
        pub bias: ReceiverBias,
        /// Number of levels.
        pub depth: u32,
        /// Level of the cells outside all regions.
        pub base_level: u32,
        /// Reach of the kernel on either side of its centre, in cells.
        pub reach: u32,
        /// Tap weights at distances 0, 1 and 2 along an axis, four bits each, lowest bits first.
        pub tap_weights: u32,
        /// 1 if taps behind the receiver's plane count too.
        pub counts_all_taps: u32,
    }
}

gpu_struct! {
    /// The tree's cell levels by region, in plan view: `crate::tree::query::PlanLevels`.
    pub struct CubesPlan {
        /// Region edges along x in voxels, ascending, four per element.
        pub edges_x: Array<[i32; 4], 8>,
        /// Region edges along z in voxels, ascending, four per element.
        pub edges_z: Array<[i32; 4], 8>,
        /// Levels of the rectangles between the edges, x fastest: four bits each, lowest bits first, eight
        /// per word.
        pub levels: Array<[u32; 4], 35>,
        /// Number of edges along x in use, at most twice [`MAX_PLAN_REGIONS`].
        pub edge_count_x: u32,
        /// Number of edges along z in use, at most twice [`MAX_PLAN_REGIONS`].
        pub edge_count_z: u32,
    }
}

gpu_struct! {
    /// The uniform for look-ups in a tree.
    pub struct CubesUniform {
        /// The tree.
        pub params: CubesParams,
        /// The tree's regions.
        pub plan: CubesPlan,
    }
}

gpu_struct! {
    /// A receiver in a tree, for the pass that evaluates lists of them: `crate::tree::query::TreeReceiver`.
    pub struct CubesQuery {
        /// Grid position, fixed point.
        pub p_fixed: [i32; 3],
        /// Level of the cells.
        pub level: u32,
        /// Normal of the receiver, fixed point.
        pub normal: [i32; 3],
        /// Height above the receiver's plane in cells, fixed point.
        pub height: i32,
    }
}

gpu_struct! {
    /// Parameters of the pass that decodes a texture's words into a buffer.
    pub struct DecodeParams {
        /// Index of the buffer's first word among all words.
        pub first_word: u32,
    }
}

/// All structures of trees, each listed after the ones it contains.
pub const STRUCTS: &[StructInfo] =
    &[CubesParams::INFO, CubesPlan::INFO, CubesUniform::INFO, CubesQuery::INFO, DecodeParams::INFO];

/// The declarations of [`STRUCTS`] and of the constants of trees. They come before every other file of a
/// tree.
pub fn tree_declarations() -> Source {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        let mut text = format!(
            "const ADUMBRA_NORMAL_ONE: i32 = {NORMAL_ONE};\nconst ADUMBRA_MAX_HEIGHT_CELLS: i32 = {MAX_HEIGHT_CELLS};\n"
        );
        STRUCTS.iter().for_each(|structure| text += &(structure.declare)());
        text
    });
    Source { name: "tree", text: &TEXT }
}

/// The constants of graphs. They come before every other file of a graph.
pub fn graph_declarations() -> Source {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        [
            ("TOP_LIT", plain::LIT),
            ("TOP_SHADOWED", plain::SHADOWED),
            ("PACKED_POOL_WORDS", packed::POOL_WORDS as u32),
            ("PACKED_NEAR_UNITS", packed::NEAR_UNITS),
        ]
        .map(|(name, value)| format!("const ADUMBRA_{name}: u32 = {value}u;\n"))
        .concat()
    });
    Source { name: "graph", text: &TEXT }
}

macro_rules! sources {
    ($($(#[$doc:meta])* $name:ident = $path:literal;)*) => {
        $($(#[$doc])* pub const $name: Source =
            Source { name: $path, text: include_str!(concat!("../../wgsl/", $path)) };)*
    };
}

sources! {
    /// Look-up in a graph.
    GRAPH = "core/voxel_graph.wgsl";
    /// Nodes of a graph in the plain layout.
    GRAPH_PLAIN = "core/voxel_plain.wgsl";
    /// Nodes of a graph in the packed layout.
    GRAPH_PACKED = "core/voxel_packed.wgsl";
    /// The level at which a look-up in a graph ends.
    GRAPH_LEVEL = "core/voxel_level.wgsl";
    /// Look-up in a tree.
    CUBES = "core/voxel_cubes.wgsl";
    /// Converts a surface to a receiver.
    CUBES_RECEIVER = "core/voxel_cubes_receiver.wgsl";
    /// The level at which a look-up ends.
    CUBES_LEVEL = "core/voxel_cubes_level.wgsl";
    /// Words from the pages of an RGBA8 texture.
    WORDS_TEXTURE = "access/words_texture.wgsl";
    /// A tree's uniform and regions.
    CUBES_MAP = "passes/voxel_cubes_map.wgsl";
    /// The techniques `voxel-cubes` and `voxel-texture`.
    CUBES_PASS = "passes/voxel_cubes.wgsl";
    /// The level at which a look-up ends, as a pass.
    CUBES_LEVEL_PASS = "passes/voxel_cubes_level.wgsl";
    /// Tap weights for receivers in fixed point.
    CUBES_FIXED = "passes/voxel_cubes_fixed.wgsl";
    /// Decodes a texture's words into a storage buffer.
    DECODE_TEXTURE = "passes/decode_texture.wgsl";
}
