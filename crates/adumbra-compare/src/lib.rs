//! Compares shadows and ambient occlusion with ray-traced truth. `adumbra compare`, the viewer and the
//! laboratory use it.
//!
//! | module | contents |
//! |---|---|
//! | [`truth`] | ray-traced surfaces, sun and ambient visibility, cached; shadow edges; street-level cameras |
//! | [`metrics`] | RMSE and shares of wrong pixels for shadow factors, by distance; SSIM and FLIP for pictures |
//! | [`mod@compare`] | techniques drawn at one camera or along a path, and compared with the truth |
//! | [`camera_file`] | cameras as JSON |
//! | [`paths`], [`shimmer`] | camera paths; how shadow factors at fixed points change along them |
//! | [`swept`], [`changes`] | a sun that moves across a day; how often pixels change between lit and dark meanwhile |
//! | [`report`], [`pictures`] | tables and JSON; difference pictures and sheets |
//! | [`contenders`], [`baked`] | the techniques of a comparison, and the baked files that they need |
//! | [`layers`] | layers of a frame as PNG and EXR |
//! | [`verbs`] | the verbs `compare` and `render` |
//! | [`args`] | command-line options that need the renderer |

// These macros panic if the output cannot be written.
#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod args;
pub mod baked;
pub mod camera_file;
pub mod changes;
pub mod compare;
pub mod contenders;
pub mod error;
pub mod layers;
pub mod metrics;
pub mod paths;
pub mod pictures;
pub mod report;
pub mod shimmer;
pub mod swept;
pub mod truth;
pub mod vector;
pub mod verbs;

pub use error::{Error, Result};
