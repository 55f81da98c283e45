//! Compares shadows with ray-traced truth.

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
