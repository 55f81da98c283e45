//! Ambient occlusion compared with ray-traced truth: errors of visibility, flicker along a camera path, the
//! paper's claims as numbers, the eight scenes of `bench ao`, and the tuner that gives every estimator an
//! equal chance on them.
//!
//! All values are visibility: 1 = unoccluded.

mod claims;
mod errors;
mod flicker;
mod measure;
mod record;
mod tune;
mod views;
mod walk;

pub(crate) use claims::{BLUR_PIXELS, EDGE_COSINE, EDGE_PIXELS, EDGE_STEP};
pub use claims::{ClaimProbe, Claims, FLAT, OPEN};
pub use errors::{OcclusionErrors, grey_picture, occlusion_errors};
pub use flicker::{CHANGE, Flicker, FlickerCount, FlickerFrame};
pub use measure::{OcclusionReference, OcclusionStage, TracedView};
pub use record::{Record, RecordEntry, RecordScene, TunedOn, tuned, with_tuned};
pub use tune::{TuneOptions, TuneScene, tune};
pub use views::{Fold, OcclusionScene, OcclusionView, PATH_FRAMES, SCENES, scene_named};
pub use walk::path_flicker;
pub(crate) use walk::truth_flicker;
