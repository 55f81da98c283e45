//! Compares shadows with ray-traced truth.

pub mod error;
pub mod metrics;
pub mod truth;
mod vector;

pub use error::{Error, Result};
