//! The techniques by name: their properties, their parameters, and how they are built.
//!
//! [`TECHNIQUES`] is the list of them all. [`build()`] builds a technique from its text, and [`describe()`] lists its
//! parameters without a device. Both read the settings with the same code, so help and sliders show exactly what is
//! accepted. [`change`] sets one parameter and omits those that no longer apply. Ambient occlusion has its own list:
//! [`crate::occlusion`].

mod ask;
mod baked;
mod blur;
mod build;
mod describe;
mod none;
mod parameters;
mod registry;
mod traits;

pub use baked::Baked;
pub use build::build;
pub use describe::{change, describe};
pub use parameters::{parameter_texts, parameters};
pub use registry::{TECHNIQUES, TechniqueEntry};
pub use traits::{Reads, Truth};
