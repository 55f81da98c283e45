//! Bakes the path of a sun: a few *key* suns, between which a march through their depths answers for any
//! moment.
//!
//! Keys are placed by error. The distance to the next key is as large as the error half way allows. There,
//! visible points are looked up between the keys and in a file of that very sun, and both are compared with
//! rays. So keys are close where the sun is low and shadows are long, and far apart around noon.
//!
//! All keys share one lattice: voxels of one size in the oblique frame, with one yaw. Data flows one way:
//! options, visible → place → bake and measure. `follow` is independent of these.

mod bake;
mod error;
mod follow;
mod hidden;
mod measure;
mod options;
mod place;
mod visible;

pub use bake::{BakedKey, BakedPath, bake_path};
pub use error::{Error, Result};
pub use follow::{FollowOptions, Followed, FollowedMoment, PathReader, SunFollower};
pub use measure::{Moment, measure};
pub use options::PathOptions;
pub use place::GapError;
pub use visible::{LEAST_N_DOT_L, VisiblePoint, visible_points};
