//! Shadow maps: their layers, filters and moments.

use super::ReceiverBias;
use super::kinds::Array;
use crate::gpu_struct;

gpu_struct! {
    /// One layer of a shadow map. Depth convention of the light: linear, 0 near the sun, 1 far. The rows are
    /// those of an affine transformation; each evaluates to `xyz · p_relative + w`.
    pub struct MapLayer {
        /// Row that yields u, 0 to 1 from left to right.
        pub u_from_relative: [f32; 4],
        /// Row that yields v, 0 to 1 from top to bottom.
        pub v_from_relative: [f32; 4],
        /// Row that yields depth, 0 to 1.
        pub depth_from_relative: [f32; 4],
        /// Side length of a texel, in world units.
        pub texel_world: f32,
        /// Distance between depth 0 and depth 1, in world units.
        pub depth_world: f32,
        /// View depth at which the layer ends.
        pub end_view_depth: f32,
        /// View depth at which the blend into the next layer begins.
        pub blend_view_depth: f32,
    }
}

impl MapLayer {
    /// A layer without extent, used before the first frame.
    pub const EMPTY: Self = Self {
        u_from_relative: [0.0; 4],
        v_from_relative: [0.0; 4],
        depth_from_relative: [0.0; 4],
        texel_world: 1.0,
        depth_world: 1.0,
        end_view_depth: 0.0,
        blend_view_depth: 0.0,
    };
}

gpu_struct! {
    /// Parameters that turn depth moments into a visibility.
    pub struct MomentParams {
        /// Exponents of the positive and the negative warp.
        pub exponents: [f32; 2],
        /// Smallest standard deviation of depth, in texels.
        pub min_deviation_texels: f32,
        /// Fraction of the bound's tail that is cut off, against light bleeding.
        pub bleed: f32,
    }
}

gpu_struct! {
    /// A shadow map of up to [`crate::constants::MAX_LAYERS`] layers, with its filter parameters.
    pub struct MapParams {
        /// The layers, nearest to the camera first.
        pub layers: Array<MapLayer, 8>,
        /// Bias applied to the receiver.
        pub bias: ReceiverBias,
        /// Parameters of moment-based filters.
        pub moments: MomentParams,
        /// Number of layers in use.
        pub layer_count: u32,
        /// Side length of a layer, in texels.
        pub side_texels: u32,
        /// Filter width, in texels.
        pub filter_width: u32,
        /// Number of filter taps.
        pub tap_count: u32,
        /// Largest radius of the filter, in texels.
        pub max_radius_texels: f32,
        /// Tangent of half the sun's angular diameter.
        pub sun_tangent: f32,
        /// View depth at which shadows begin to fade out.
        pub fade_view_depth: f32,
        /// View depth at which shadows end.
        pub fade_end_view_depth: f32,
        /// Smallest bias along the light, as a fraction of the layer's depth: one step of 16-bit depth, or a
        /// few units in the last place of 32-bit depth.
        pub min_bias_depth: f32,
        /// Side length of a pixel at view depth 0, in world units.
        pub pixel_world: f32,
        /// Change of [`MapParams::pixel_world`] per unit of view depth.
        pub pixel_world_per_depth: f32,
        /// Number of mip levels of the moments.
        pub mip_levels: f32,
    }
}

gpu_struct! {
    /// Parameters of a pass that blurs the moments of one layer.
    pub struct MomentBlurParams {
        /// Weights of the central tap and of the taps to one side, four per element. Together with the
        /// mirrored taps they sum to 1.
        pub weights: Array<[f32; 4], 4>,
        /// Exponents of the positive and the negative warp.
        pub exponents: [f32; 2],
        /// Layer index in the depth map.
        pub layer: u32,
        /// Side length of the layer, in texels.
        pub side_texels: u32,
        /// Number of taps on either side of the central one.
        pub taps_per_side: u32,
    }
}
