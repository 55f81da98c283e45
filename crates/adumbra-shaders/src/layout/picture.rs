//! Finished pictures: their lighting, the displayed layer, the window. Colours are linear.

use super::kinds::Array;
use crate::gpu_struct;

gpu_struct! {
    /// Lighting of the composite pass.
    pub struct CompositeParams {
        /// Colour of the sunlight.
        pub sun_color: [f32; 3],
        /// Colour of the light from above, also used for the sky behind the scene.
        pub sky_color: [f32; 3],
        /// Colour of the light from below.
        pub ground_color: [f32; 3],
    }
}

gpu_struct! {
    /// Parameters that select the displayed part of a frame.
    pub struct LayerParams {
        /// Tint colours by index.
        pub palette: Array<[f32; 3], 16>,
        /// Width and height of the picture shown, in pixels.
        pub size: [u32; 2],
        /// Frame pixels per displayed pixel along a side.
        pub samples: u32,
        /// Layer to show: `LAYER_...`.
        pub kind: u32,
        /// Number of palette colours in use.
        pub tint_count: u32,
    }
}

gpu_struct! {
    /// Parameters for showing one or two pictures in a window.
    pub struct PresentParams {
        /// Colour where the second picture is darker.
        pub too_dark: [f32; 3],
        /// Gain applied to differences in brightness.
        pub gain: f32,
        /// Colour where the second picture is brighter.
        pub too_bright: [f32; 3],
        /// Display mode: `PRESENT_...`.
        pub kind: u32,
        /// Column of the divider, in pixels.
        pub divider: u32,
        /// 1 if the window's surface applies the sRGB encoding itself.
        pub window_encodes: u32,
    }
}
