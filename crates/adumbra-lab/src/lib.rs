//! Compares shadows with ray-traced truth.
//!
//! | module | holds |
//! |---|---|
//! | [`truth`] | what a camera sees and what the sun sees of it, by rays; kept on disk; edges; street-level cameras |
//! | [`metrics`] | RMSE and wrong shares of factors, by distance; SSIM and FLIP of pictures |
//! | [`mod@compare`] | techniques drawn and judged at one camera, or walked along a path |
//! | [`paths`], [`shimmer`] | camera paths; how factors at fixed points change along them |
//! | [`report`], [`pictures`], [`peers`] | tables and JSON; difference pictures and sheets; today's engines beside ours |

pub mod compare;
pub mod error;
pub mod metrics;
pub mod paths;
pub mod peers;
pub mod pictures;
pub mod report;
pub mod shimmer;
pub mod truth;
mod vector;

pub use error::{Error, Result};
