//! The `.adumbra` file, version 2, and version 1 for reading: bytes <-> grid, settings and graph. `spec/adumbra-file.md` describes it for readers
//! in other languages.
//!
//! | part | bytes | meaning |
//! |---|---|---|
//! | header | 384 | magic, version, grid, settings, section table, checksum (`header.rs`) |
//! | top | 4 a word | the top grid |
//! | nodes | 4 a word | headers and pointers; packed, two units a word; of a hierarchy, two half-words of its code |
//! | slabs | 8 a slab | 8 × 8 × 1 visibility masks; of a hierarchy, wide entries |
//!
//! Little-endian throughout. Sections begin at multiples of 16, with zeros in the gaps; each has a CRC-32. There is
//! exactly one file for a given grid, settings and graph, and it holds nothing that varies between runs.
//!
//! [`mod@tree`] is the other kind of file, of the world-aligned tree; [`AnyFile`] is either.

mod any;
mod body;
mod error;
mod fields;
mod header;
mod read;
mod sections;
pub mod tree;
mod words;
mod write;

pub use any::AnyFile;
pub use body::{Layout, LightBody};
pub use error::FormatError;
pub use header::{HEADER_BYTES, MAGIC, VERSION};
pub use tree::{AttributeKind, TreeBody, TreeFile};
pub use words::WordsError;

use std::borrow::Cow;

use crate::dag::packed::{PackError, PackedError};
use crate::dag::{Dag, Slabs};
use crate::hierarchy::Hierarchy;
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
    pub body: LightBody,
}

impl ShadowFile {
    /// A file of the plain layout.
    pub fn plain(grid: LightGrid, settings: Settings, dag: Dag) -> Self {
        Self { grid, settings, body: LightBody::Plain(dag) }
    }

    /// A file of the layout that is a hierarchy.
    pub fn hierarchy(grid: LightGrid, settings: Settings, hierarchy: Hierarchy) -> Self {
        Self { grid, settings, body: LightBody::Hierarchy(hierarchy) }
    }

    /// A file of any layout.
    ///
    /// # Errors
    /// [`PackError`] where the graph has no packed form.
    pub fn of_dag(
        grid: LightGrid,
        settings: Settings,
        dag: Dag,
        layout: Layout,
    ) -> std::result::Result<Self, PackError> {
        Ok(Self { grid, settings, body: LightBody::of_dag(dag, layout)? })
    }

    /// The graph in the plain layout, for what reads only that. Cost: none where it is, else that of
    /// [`to_dag`](crate::dag::packed::PackedDag::to_dag).
    ///
    /// # Errors
    /// [`FormatError::Packed`] or [`FormatError::Hierarchy`] where the words are not valid, [`FormatError::TooLarge`] where the graph could
    /// be too large: few bytes of either layout can stand for any number of root cubes.
    pub fn graph(&self) -> std::result::Result<Cow<'_, Dag>, FormatError> {
        Ok(match &self.body {
            LightBody::Plain(dag) => Cow::Borrowed(dag),
            LightBody::Packed(packed) => match packed.to_dag() {
                Err(PackedError::TooLarge(limit)) => return Err(limit.into()),
                found => Cow::Owned(found?),
            },
            LightBody::Hierarchy(hierarchy) => {
                hierarchy.validate()?;
                Cow::Owned(hierarchy.to_dag()?)
            }
        })
    }

    /// What look-ups read, whatever the layout.
    pub fn slabs(&self) -> &dyn Slabs {
        self.body.slabs()
    }
}
