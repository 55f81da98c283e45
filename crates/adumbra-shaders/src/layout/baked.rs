//! Baked files: light-aligned grids of voxels.

use super::ReceiverBias;
use crate::gpu_struct;

gpu_struct! {
    /// Transform from relative positions to a voxel grid, accurate to better than 1e-5 voxels for any grid
    /// size. A position is split into whole steps of about 8 voxels, whose contribution is exact in integers,
    /// and a remainder; core/grid.wgsl adds the two. Fixed-point numbers have [`crate::constants::FIXED_ONE`]
    /// units per voxel and wrap.
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
    /// A baked light-aligned file. Its words are the blocks at which look-ups begin, and the code; offsets
    /// are in words.
    pub struct VoxelParams {
        /// Position and orientation of the grid.
        pub grid: GridTransform,
        /// Number of blocks at which look-ups begin along x and y, and 1.
        pub root_count: [u32; 3],
        /// Level of these blocks.
        pub root_level: u32,
        /// Bias applied to the receiver.
        pub bias: ReceiverBias,
        /// For a quadtree: offset of the table of blocks, number of coarser levels that follow, and 1 if
        /// pages may be absent, 2 if they also fade; zeros unless it is streamed. Other structures with the
        /// same filters keep offsets here.
        pub extra: [u32; 3],
        /// Offset of the code.
        pub code_offset: u32,
        /// Filter width, in texels.
        pub filter_width: u32,
        /// Growth of the sun cone's radius per voxel of depth, in texels (penumbrae).
        pub sun_cone: f32,
        /// Largest radius of a penumbra, in texels (penumbrae).
        pub max_radius_texels: f32,
        /// First row of the map from a circle across the light to its outline in the grid (penumbrae).
        pub penumbra_x: [f32; 2],
        /// Second row of the map from a circle across the light to its outline in the grid (penumbrae).
        pub penumbra_y: [f32; 2],
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
