//! The screen-space blur of the shadow factor.

use super::kinds::Array;
use crate::gpu_struct;

gpu_struct! {
    /// Two independent tables in one: the weight of a texel at distance i, and tap pair i, which one linearly
    /// filtered sample reads.
    pub struct BlurTap {
        /// Weight of a texel at distance i, in texels; the weights of a whole line add up to 1.
        pub weight: f32,
        /// Sample position of pair i, in texels from the centre.
        pub pair_offset_texels: f32,
        /// Weight of pair i.
        pub pair_weight: f32,
    }
}

gpu_struct! {
    /// Parameters of a screen-space blur of the shadow factor. "Texels" are those of the blurred picture,
    /// which may have half the frame's size.
    pub struct BlurParams {
        /// Weights by distance, and pairs by index.
        pub taps: Array<BlurTap, 33>,
        /// Width and height in texels.
        pub size: [u32; 2],
        /// Width and height of the frame in pixels.
        pub frame_size: [u32; 2],
        /// Number of taps on either side.
        pub taps_per_side: u32,
        /// Number of tap pairs on either side.
        pub pair_count: u32,
        /// Frame pixels per texel along a side, 1 or 2.
        pub pixels_per_texel: u32,
        /// Axis of a one-dimensional pass: 0 for x, 1 for y.
        pub axis: u32,
        /// Radius of the dilation, in texels.
        pub dilation_texels: u32,
        /// Standard deviation of the Gaussian, in texels.
        pub sigma_texels: f32,
        /// Distance from a pixel's plane at which a point no longer counts as the same surface, in pixel
        /// widths at that depth.
        pub tolerance_pixels: f32,
    }
}
