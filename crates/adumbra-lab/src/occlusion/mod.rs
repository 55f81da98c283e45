//! Ambient occlusion judged by rays: errors of visibility, flicker along a camera path, and the eight scenes of `bench ao`.
//!
//! One polarity: visibility, 1 = unoccluded.

mod errors;
mod flicker;
mod views;

pub use errors::{OcclusionErrors, grey_picture, occlusion_errors};
pub use flicker::{CHANGE, Flicker, FlickerCount, FlickerFrame};
pub use views::{Fold, OcclusionScene, OcclusionView, PATH_FRAMES, SCENES, scene_named};
