//! Screen-space ambient occlusion.

use super::DepthToZ;
use super::kinds::Array;
use crate::gpu_struct;

gpu_struct! {
    /// Conversion between texels of the ambient occlusion picture and view space. View space has x to the
    /// right, y up and z along [`super::Frame::forward`], in world units from the eye.
    pub struct OcclusionView {
        /// Change of `ndc` per texel. `ndc` ranges from -1 to 1, y up.
        pub ndc_per_texel: [f32; 2],
        /// `ndc` of the centre of the first texel.
        pub ndc_of_first_texel: [f32; 2],
        /// Half extent of the view along x and y at view depth 0, in world units.
        pub half_view: [f32; 2],
        /// Change of [`OcclusionView::half_view`] per unit of view depth.
        pub half_view_per_depth: [f32; 2],
        /// World-space unit vector of view space's x axis.
        pub right: [f32; 3],
        /// World-space unit vector of view space's y axis.
        pub up: [f32; 3],
        /// World-space unit vector of view space's z axis.
        pub forward: [f32; 3],
    }
}

gpu_struct! {
    /// Parameters specific to the estimators. Each estimator's file states which ones it reads; the others
    /// are 0.
    pub struct OcclusionShape {
        /// Factor of the sum.
        pub strength: f32,
        /// Exponent of the visibility.
        pub exponent: f32,
        /// Distance by which an occluder must rise, or be nearer, before it counts.
        pub bias: f32,
        /// Largest view depth, in radii, by which the bias is scaled.
        pub max_bias_depth: f32,
        /// Term added to a squared distance before it is used as a divisor.
        pub epsilon: f32,
        /// Depth difference, in radii, up to which an occluder counts fully.
        pub range: f32,
        /// Minimum height of an occluder above the tangent plane.
        pub min_rise: f32,
        /// Exponent of the falloff with distance.
        pub falloff_exponent: f32,
        /// Decrease of an occluder's weight per unit of distance.
        pub falloff_slope: f32,
        /// Factor of distances along the view direction.
        pub depth_stretch: f32,
        /// 1 if anything in front of the sphere of the given radius hides the sphere's inside.
        pub hides_from_outside: u32,
    }
}

gpu_struct! {
    /// An estimate of ambient occlusion. "Texels" are those of its own picture, which may have half the
    /// frame's size.
    pub struct OcclusionParams {
        /// Conversion from texels to view space.
        pub view: OcclusionView,
        /// Conversion from stored depth to view depth.
        pub depth_to_z: DepthToZ,
        /// Parameters specific to the estimator.
        pub shape: OcclusionShape,
        /// Width and height in texels.
        pub size: [u32; 2],
        /// Frame pixels per texel along a side, 1 or 2.
        pub pixels_per_texel: u32,
        /// Pixels of the normal picture per texel along a side, 1 or 2.
        pub pixels_per_normal: u32,
        /// Number of taps.
        pub tap_count: u32,
        /// Number of steps along a march.
        pub step_count: u32,
        /// Offset added to a texel's index in the noise tile.
        pub tile_offset: u32,
        /// Smallest fraction of the taps used at any distance, in quarters.
        pub min_quarters: u32,
        /// Distance beyond which nothing occludes, in world units.
        pub radius_world: f32,
        /// Largest radius on the screen, in texels.
        pub max_radius_texels: f32,
        /// Side length of a texel at view depth 0, in world units.
        pub texel_world: f32,
        /// Change of [`OcclusionParams::texel_world`] per unit of view depth.
        pub texel_world_per_depth: f32,
    }
}

gpu_struct! {
    /// The noise of ambient occlusion: [`crate::constants::OCCLUSION_MAX_TAPS`] taps for each of the tile's
    /// 16 texels. Each estimator's file states what the components of a tap mean.
    pub struct OcclusionTaps {
        /// Taps, grouped by texel.
        pub taps: Array<[f32; 4], 1024>,
    }
}

gpu_struct! {
    /// Parameters of a pass that filters ambient visibility.
    pub struct OcclusionFilterParams {
        /// Width and height in texels.
        pub size: [u32; 2],
        /// Number of taps on either side.
        pub taps_per_side: u32,
        /// Axis of a one-dimensional pass: 0 for x, 1 for y.
        pub axis: u32,
        /// Which planes the filter follows, as 1 or 0: those of a perspective picture, and those of an
        /// orthographic one.
        pub plane_kind: [f32; 2],
        /// 1 / (√2 σ), where σ is the standard deviation of view depth in world units.
        pub inverse_depth_width: f32,
        /// 1 / (2 σ²), where σ is the standard deviation of the distance in texels.
        pub inverse_distance_width: f32,
        /// Difference in visibility that the edge test ignores; negative disables the test.
        pub edge_tolerance: f32,
    }
}

gpu_struct! {
    /// Transform from this frame's view space to the previous frame's. Each row evaluates to `xyz · p + w`
    /// for a point p in this frame's view space.
    pub struct OcclusionHistoryParams {
        /// Row that yields x in the previous frame.
        pub x_from_now: [f32; 4],
        /// Row that yields y in the previous frame.
        pub y_from_now: [f32; 4],
        /// Row that yields view depth in the previous frame.
        pub z_from_now: [f32; 4],
        /// View of the previous frame.
        pub view: OcclusionView,
        /// Distance from a point's plane within which the previous frame's surface counts as the same, at
        /// view depth 0, in world units.
        pub tolerance_world: f32,
        /// Change of [`OcclusionHistoryParams::tolerance_world`] per unit of view depth.
        pub tolerance_world_per_depth: f32,
        /// Largest number of accumulated frames.
        pub max_frames: f32,
        /// 1 if there was a previous frame.
        pub has_before: u32,
    }
}
