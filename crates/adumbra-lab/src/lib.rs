//! Compares shadows and ambient occlusion with ray-traced truth.
//!
//! | module | holds |
//! |---|---|
//! | [`truth`] | what a camera sees, what the sun sees of it and what is open around it, by rays; kept on disk; edges; street-level cameras |
//! | [`metrics`] | RMSE and wrong shares of factors, by distance; SSIM and FLIP of pictures |
//! | [`mod@compare`] | techniques drawn and judged at one camera, or walked along a path |
//! | [`camera_file`] | cameras as JSON |
//! | [`paths`], [`shimmer`] | camera paths; how factors at fixed points change along them |
//! | [`occlusion`] | ambient occlusion: errors, flicker, and the eight scenes it is measured on |
//! | [`page`] | pages of HTML that need nothing but themselves |
//! | [`report`], [`pictures`], [`peers`] | tables and JSON; difference pictures and sheets; today's engines beside ours |

pub mod camera_file;
pub mod compare;
pub mod error;
pub mod metrics;
pub mod occlusion;
pub mod page;
pub mod paths;
pub mod peers;
pub mod pictures;
pub mod report;
pub mod shimmer;
pub mod truth;
mod vector;

pub use error::{Error, Result};
