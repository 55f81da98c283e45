//! Baked files: light-aligned grids of voxels, and world-aligned trees.

use super::ReceiverBias;
use super::kinds::{Array, gpu_struct};

gpu_struct! {
    /// Transform from relative positions to a voxel grid, accurate to better than 1e-5 voxels for any grid size. A
    /// position is split into whole steps of about 8 voxels, whose contribution is exact in integers, and a remainder;
    /// core/grid.wgsl adds the two. Fixed-point numbers have [`crate::constants::FIXED_ONE`] units per voxel and wrap.
    pub struct GridTransform {
        /// First row of the linear map from world to grid.
        pub axis_x: [f32; 3],
        /// Second row of the linear map from world to grid.
        pub axis_y: [f32; 3],
        /// Third row of the linear map from world to grid.
        pub axis_z: [f32; 3],
        /// Edge of a voxel along the grid's x in the world, in voxel sizes. Edges convert normals.
        pub edge_x: [f32; 3],
        /// Edge of a voxel along the grid's y in the world, in voxel sizes.
        pub edge_y: [f32; 3],
        /// Edge of a voxel along the grid's z in the world, in voxel sizes.
        pub edge_z: [f32; 3],
        /// Change of the grid position per step along the world's x axis, fixed point.
        pub step_x: [i32; 3],
        /// Change of the grid position per step along the world's y axis, fixed point.
        pub step_y: [i32; 3],
        /// Change of the grid position per step along the world's z axis, fixed point.
        pub step_z: [i32; 3],
        /// Rounding remainder of [`GridTransform::step_x`], in voxels.
        pub rest_x: [f32; 3],
        /// Rounding remainder of [`GridTransform::step_y`], in voxels.
        pub rest_y: [f32; 3],
        /// Rounding remainder of [`GridTransform::step_z`], in voxels.
        pub rest_z: [f32; 3],
        /// Grid position of the anchor, fixed point.
        pub anchor_fixed: [i32; 3],
        /// Rounding remainder of [`GridTransform::anchor_fixed`], in voxels.
        pub anchor_remainder: [f32; 3],
        /// Grid position of the anchor in voxels, rounded to floats.
        pub anchor_voxels: [f32; 3],
        /// Grid size along x, y and z, in voxels.
        pub size: [i32; 3],
        /// Voxels per world unit.
        pub voxels_per_world: f32,
        /// World units per step, a power of two.
        pub step_world: f32,
        /// Steps per world unit.
        pub steps_per_world: f32,
    }
}

gpu_struct! {
    /// A baked light-aligned file of any layout. Its words are the file's sections, concatenated; offsets are in words.
    pub struct VoxelParams {
        /// Position and orientation of the grid.
        pub grid: GridTransform,
        /// Number of root cubes along x, y and z; 1 along z in the layout "depths".
        pub root_count: [u32; 3],
        /// Level of the root cubes.
        pub root_level: u32,
        /// Bias applied to the receiver.
        pub bias: ReceiverBias,
        /// Offset of the nodes (plain) or of the units (packed).
        pub nodes_offset: u32,
        /// Offset of the leaf masks (plain and packed).
        pub masks_offset: u32,
        /// Offset of the wide entries (depths).
        pub wide_offset: u32,
        /// Offset of the code (depths).
        pub code_offset: u32,
        /// Filter width, in texels.
        pub filter_width: u32,
        /// Growth of the sun cone's radius per voxel of depth, in texels (depths, penumbrae).
        pub sun_cone: f32,
        /// Largest radius of a penumbra, in texels (depths, penumbrae).
        pub max_radius_texels: f32,
        /// First row of the map from a circle across the light to its outline in the grid (depths, penumbrae).
        pub penumbra_x: [f32; 2],
        /// Second row of the map from a circle across the light to its outline in the grid (depths, penumbrae).
        pub penumbra_y: [f32; 2],
    }
}

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
    /// The tree's cell levels by region, in plan view: `adumbra_tree::query::PlanLevels`.
    pub struct CubesPlan {
        /// Region edges along x in voxels, ascending, four per element.
        pub edges_x: Array<[i32; 4], 8>,
        /// Region edges along z in voxels, ascending, four per element.
        pub edges_z: Array<[i32; 4], 8>,
        /// Levels of the rectangles between the edges, x fastest: four bits each, lowest bits first, eight per word.
        pub levels: Array<[u32; 4], 35>,
        /// Number of edges along x in use, at most twice [`crate::constants::MAX_PLAN_REGIONS`].
        pub edge_count_x: u32,
        /// Number of edges along z in use, at most twice [`crate::constants::MAX_PLAN_REGIONS`].
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
    /// A fixed-point receiver, for the pass that evaluates lists of them: `adumbra::query::FixedReceiver`.
    pub struct VoxelQuery {
        /// Grid position, fixed point.
        pub p_fixed: [i32; 3],
        /// Gradient of the receiver's plane along x and y, fixed point.
        pub gradient: [i32; 2],
    }
}

gpu_struct! {
    /// A receiver in a tree, for the pass that evaluates lists of them: `adumbra_tree::query::TreeReceiver`.
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
