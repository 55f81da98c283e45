//! The shaders of adumbra: plain WGSL in `wgsl/`, and what Rust and WGSL must agree on.
//!
//! | folder | holds |
//! |---|---|
//! | `wgsl/core/` | functions without bindings: look-ups, filters, cascades. An engine includes these |
//! | `wgsl/access/` | where words come from: one buffer, several, a texture; those of hybrid maps |
//! | `wgsl/passes/` | bindings and entry points |
//!
//! A module is made by [`assemble`]: [`layout::declarations`] and [`constants::declarations`], then the files asked for, in order.
//! Nothing is preprocessed. Structures and constants are declared once, in Rust; a test holds the structures against naga's layout.

pub mod constants;
pub mod layout;
pub mod source;

pub use source::{Source, assemble};
