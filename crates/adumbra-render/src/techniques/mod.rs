//! The techniques by name: their properties, their parameters, and how they are built.
//!
//! [`TECHNIQUES`] lists the techniques of this crate. [`Techniques::parse`] turns a text into a
//! [`TechniqueSpec`], whose name and parameters are known to exist. The spec has methods that describe and
//! change it, and [`build()`] builds it. Building and describing read the settings with the same code, so
//! help and sliders show exactly what is accepted. A dependent crate adds its techniques with
//! [`Techniques::with`]. Ambient occlusion has its own list: [`crate::occlusion`].

mod baked;
mod list;
mod none;
mod parameters;
mod product;
#[cfg(test)]
mod tests;
mod traits;

pub use baked::TechniqueFiles;
pub use list::{Design, Role, TechniqueEntry, TechniqueSpec, Techniques, build};
pub use product::TECHNIQUES;
pub use traits::{Reads, Traits, Truth};
