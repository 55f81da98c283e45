//! The `.adumbra` file: conversion between its bytes and a grid, settings and voxels. `spec/adumbra-file.md` specifies the format for readers in other languages.
//!
//! | part | bytes | meaning |
//! |---|---|---|
//! | header | 384 | magic, version, grid, settings, section table, checksum (`header.rs`) |
//! | top | 8 per root | the top grid |
//! | nodes | 4 per word | two half-words of code per word |
//! | leaf masks | 8 each | wide entries |
//!
//! All values are little-endian. Sections begin at multiples of 16 bytes, with zeros in the gaps, and each has a
//! CRC-32. There is exactly one file for a given grid, settings and voxels, and it contains nothing that varies between
//! runs.

mod body;
pub mod fields;
mod header;
mod read;
pub mod sections;
mod write;

pub use header::{HEADER_BYTES, Header, MAGIC, VERSION};

use std::sync::Arc;

use crate::grid::{LightGrid, Sun};
use crate::layout::Composition;
use crate::layout::depths::DepthTree;
use crate::settings::FileSettings;

/// The contents of a `.adumbra` file.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowFile {
    /// Placement of the voxels in the world.
    pub grid: LightGrid,
    /// Settings of the bake.
    pub settings: FileSettings,
    /// The voxels. Look-ups share them.
    #[doc(hidden)]
    pub tree: Arc<DepthTree>,
}

impl ShadowFile {
    /// Creates a file of its contents, which [`ShadowFile::write_to`] checks.
    #[doc(hidden)]
    pub fn new(grid: LightGrid, settings: FileSettings, tree: DepthTree) -> Self {
        Self { grid, settings, tree: Arc::new(tree) }
    }

    /// Returns the sun that the file was baked for.
    pub fn sun(&self) -> Sun {
        self.grid.sun
    }

    /// Whether the bake treated masked materials as opaque.
    pub fn ignores_alpha(&self) -> bool {
        self.settings.ignore_alpha
    }

    /// Returns the breakdown of the bytes. Cost: one pass over the voxels.
    pub fn composition(&self) -> Composition {
        self.tree.composition()
    }
}
