//! The `.adumbra` file, version 1: bytes <-> grid, settings and graph. `spec/adumbra-file.md` describes it for readers
//! in other languages.
//!
//! | part | bytes | meaning |
//! |---|---|---|
//! | header | 384 | magic, version, grid, settings, section table, checksum (`header.rs`) |
//! | top | 4 a root | the top grid |
//! | nodes | 4 a word | headers and pointers |
//! | slabs | 8 a slab | 8 × 8 × 1 visibility masks |
//!
//! Little-endian throughout. Sections begin at multiples of 16, with zeros in the gaps; each has a CRC-32. There is
//! exactly one file for a given grid, settings and graph, and it holds nothing that varies between runs.
//!
//! [`mod@tree`] is the other kind of file, of the world-aligned tree; [`AnyFile`] is either.

mod any;
mod error;
mod fields;
mod header;
mod read;
mod sections;
pub mod tree;
mod words;
mod write;

pub use any::AnyFile;
pub use error::FormatError;
pub use header::{HEADER_BYTES, MAGIC, VERSION};
pub use tree::{AttributeKind, TreeBody, TreeFile};
pub use words::WordsError;

use crate::dag::Dag;
use crate::light::LightGrid;
use crate::settings::Settings;

/// Everything that a `.adumbra` file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowFile {
    /// Where the voxels lie in the world.
    pub grid: LightGrid,
    /// What the bake was asked for.
    pub settings: Settings,
    /// The voxels.
    pub dag: Dag,
}
