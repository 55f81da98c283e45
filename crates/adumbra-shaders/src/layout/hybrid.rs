//! Hybrid-resolution shadow maps.

use super::{MapLayer, ReceiverBias};
use crate::gpu_struct;

gpu_struct! {
    /// A hybrid-resolution shadow map, for look-ups.
    pub struct HybridParams {
        /// Position of the map; its texels are those of the finest level.
        pub layer: MapLayer,
        /// Bias applied to the receiver.
        pub bias: ReceiverBias,
        /// Side length of the finest level, in texels.
        pub start_texels: u32,
        /// Number of levels above the finest.
        pub merges: u32,
        /// Filter width, in texels.
        pub filter_width: u32,
        /// 1 if the finest depths have 16 bits.
        pub has_16_bit_depth: u32,
        /// Slope of slope code 1, in steps of 1 / [`crate::constants::HYBRID_ONE`] of depth per texel, fixed
        /// point with [`crate::constants::HYBRID_SLOPE_BITS`] fraction bits.
        pub slope_unit: i32,
        /// Smallest bias along the light, as a fraction of the layer's depth: one step of stored depth.
        pub min_bias_depth: f32,
    }
}

gpu_struct! {
    /// Parameters of a pass that merges the texels of one level of a hybrid map into the next coarser level.
    pub struct HybridLevel {
        /// Side length of the finest level, in texels.
        pub start_texels: u32,
        /// Number of the level being built; 1 is the first.
        pub number: u32,
        /// Side length of the level being built, in texels.
        pub side_texels: u32,
        /// Total number of levels above the finest.
        pub merges: u32,
        /// Offset of the previous level among the words of all levels.
        pub finer_offset: u32,
        /// Offset of the level being built among the words of all levels.
        pub offset: u32,
        /// Number of words that the four children of a block take.
        pub split_size: u32,
        /// 1 if the finest depths have 16 bits.
        pub has_16_bit_depth: u32,
        /// Slope of slope code 1, in the units of [`HybridParams::slope_unit`].
        pub slope_unit: i32,
        /// Twice the distance by which a plane may be behind its texels, in steps of 1 /
        /// [`crate::constants::HYBRID_ONE`].
        pub twice_tolerance: i32,
        /// Capacity of the map in words, or in texels for the paper's layout.
        pub room: u32,
        /// Word of a texel without a caster.
        pub empty_word: u32,
    }
}
