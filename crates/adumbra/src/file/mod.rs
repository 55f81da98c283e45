//! The `.adumbra` file: conversion between its bytes and a grid, settings and voxels. Version 3 is written, and versions
//! 1 to 3 are read. `spec/adumbra-file.md` specifies the format for readers in other languages.
//!
//! | part | bytes | meaning |
//! |---|---|---|
//! | header | 384 | magic, version, grid, settings, section table, checksum (`header.rs`) |
//! | top | 4 per word | the top grid |
//! | nodes | 4 per word | headers and pointers; packed: two units per word; depths: two half-words of code per word |
//! | leaf masks | 8 each | 8 × 8 × 1 visibility masks; depths: wide entries |
//!
//! All values are little-endian. Sections begin at multiples of 16 bytes, with zeros in the gaps, and each has a
//! CRC-32. There is exactly one file for a given grid, settings and voxels, and it contains nothing that varies between
//! runs.

mod body;
pub mod fields;
mod header;
mod layout;
mod read;
pub mod sections;
mod write;

pub use body::LightBody;
pub use header::{HEADER_BYTES, Header, MAGIC, VERSION};
pub use layout::Layout;

use crate::grid::{LightGrid, Sun};
use crate::layout::LeafMasks;
use crate::settings::FileSettings;

/// The contents of a `.adumbra` file.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowFile {
    /// Placement of the voxels in the world.
    pub grid: LightGrid,
    /// Settings of the bake.
    pub settings: FileSettings,
    /// The voxels.
    pub body: LightBody,
}

impl ShadowFile {
    /// Returns the sun that the file was baked for.
    pub fn sun(&self) -> Sun {
        self.grid.sun
    }

    /// Whether the bake treated masked materials as opaque.
    pub fn ignores_alpha(&self) -> bool {
        self.settings.ignore_alpha
    }

    /// Returns the voxels for look-ups, whatever their layout.
    pub fn leaf_masks(&self) -> &dyn LeafMasks {
        self.body.leaf_masks()
    }
}
