//! The shaders of adumbra: plain WGSL in `wgsl/`, and the definitions that Rust and WGSL share.
//!
//! | folder | contents |
//! |---|---|
//! | `wgsl/core/` | functions without bindings: look-ups, filters, cascades |
//! | `wgsl/access/` | bindings of files and hybrid maps, the functions that fetch from them, and those that engines call |
//! | `wgsl/passes/` | bindings and entry points |
//!
//! [`assemble`] makes a module: the parts of [`layout::STRUCTS`] and [`constants::declarations`] that the
//! chosen files use, followed by those files in order. `adumbra::gpu` returns such modules for engines. There
//! is no preprocessor. Structures and constants are declared once, in Rust. A test checks the structures
//! against naga's layout.
//!
//! All names in `core/` and `access/`, all shared structures and constants, and all functions that
//! `core/` and `access/` expect other files to define begin with `adumbra_`, `Adumbra` or `ADUMBRA_`, so that
//! the text can be included in an engine's own shader.

mod assemble;
pub mod constants;
pub mod layout;
pub mod source;

pub use assemble::{assemble, identifiers};
pub use source::Source;
