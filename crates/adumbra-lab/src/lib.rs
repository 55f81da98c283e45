//! Compares shadows with ray-traced truth.

pub mod error;
pub mod metrics;

pub use error::{Error, Result};
