//! Ambient occlusion on the screen: one chain of passes for every estimator, so that they differ in nothing else.
//!
//! depth → view depth (at half size, if asked) → normals, from the G-buffer or made of depth → an [`Estimator`] → the frame before, where
//! it is still valid → filter → full size. The result is ambient visibility, 1 = unoccluded, for the light of the sky alone, never the
//! sun's. Source of `issao` and its filter: Qiu, Li, Wu, Shi, Zhang, *Improved Screen Space Ambient Occlusion*, Chinese Journal of
//! Computers 37(3), 2014.
//!
//! Departures from its filter: two lines stand for the square unless that is asked for, and differences of depth are taken
//! from the centre's own surface, drawn on to the tap (`depth=plane`), not from the centre's depth (`depth=plain`): what is
//! left of the noise is then less, the more so the sharper depth is judged.
//!
//! The frames before are known by the camera's way alone. What moves in the scene is met by what was seen in its plane, or
//! begins anew; what it uncovers begins anew.

mod ambient;
mod estimator;
mod history;
mod parameters;
mod passes;
mod pictures;
mod settings;
mod taps;
pub mod twin;

pub use ambient::{AmbientSource, GivenAmbient};
pub use estimator::{Estimator, MAX_PARAMETERS, Parameter, Search};
pub use parameters::{OCCLUSIONS, occlusion_options, occlusion_parameters};
pub use passes::{AMBIENT_FORMAT, OcclusionInput, OcclusionPasses};
pub use settings::{DEFAULT_RADIUS_SHARE, Filter, Normals, OcclusionSettings};
pub use taps::taps;
