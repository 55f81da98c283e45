//! Ray-traced visibilities of a picture, and the key that identifies the picture.

use adumbra_scene::Camera;

/// The inputs of a ray-traced picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TraceKey {
    /// Numbers of the scene and of the ball in it.
    pub(crate) scene: [u64; 2],
    /// Camera with one pixel per sample.
    pub(crate) camera: Camera,
    pub(crate) seconds: f64,
    /// Direction towards the sun, if its visibility is requested.
    pub(crate) sun: Option<[f64; 3]>,
    /// Radius in world units and rays per pixel, if ambient visibility is requested.
    pub(crate) ambient: Option<(f64, u32)>,
}

/// Visibilities of a picture's pixels.
pub(crate) struct Traced {
    pub(crate) key: TraceKey,
    pub(crate) sun: Option<Vec<f32>>,
    pub(crate) ambient: Option<Vec<f32>>,
}
