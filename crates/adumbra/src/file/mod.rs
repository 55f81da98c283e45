//! The `.adumbra` file: conversion between its bytes and grids, settings and voxels. `spec/adumbra-file.md`
//! specifies the format for readers in other languages.
//!
//! | part | bytes | meaning |
//! |---|---|---|
//! | header | 256 | magic, version, settings, checksum (`header.rs`) |
//! | directory | 256 per grid | placement in the world, and where the grid's parts are (`directory.rs`) |
//! | tables | 24 per bundle | lengths, checksum and depths of each bundle (`table.rs`) |
//! | common section | 4 per word | of the coarsest grid: shapes that several pages need |
//! | bundles | | of the coarsest grid: 4 × 4 pages each, along a Hilbert curve |
//! | … | | common section and bundles of the finer grids |
//!
//! All values are little-endian. Nothing is stored twice and nothing varies between runs: there is one raw
//! file for given contents, and one coded file. In a coded file common sections and bundles are stored in
//! fewer bytes (`common.rs`).

mod common;
mod contents;
mod directory;
pub mod fields;
mod header;
mod memory;
pub mod placement;
mod read;
pub mod sections;
mod table;
mod write;

pub use common::CommonSection;
pub use contents::{beginning_bytes, name_of_bundle};
pub use directory::{GridEntry, LEVEL_STEP};
pub use header::{GRID_BYTES, HEADER_BYTES, Header, MAGIC, MAX_LEVELS, VERSION};
pub use memory::{CODING_RATIO, FileMemory};
pub use table::{BUNDLE_ENTRY_BYTES, Bundle, BundleEntry, StoredBundle};
pub use write::FileWriter;

use std::sync::Arc;

use crate::grid::{LightGrid, Sun};
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
    /// Levels of less detail, the finest first.
    coarser: Vec<Level>,
}

/// The voxels of one level of detail, and their placement in the world.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Placement of the voxels in the world.
    pub grid: LightGrid,
    /// The voxels.
    pub tree: Arc<DepthTree>,
}

/// The description of a file's parts.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// The header.
    pub header: Header,
    /// The directory.
    pub grids: Vec<GridEntry>,
    /// The table of each grid.
    pub tables: Vec<Vec<BundleEntry>>,
}

impl ShadowFile {
    /// Creates a file of one level from its contents, which [`ShadowFile::write_to`] checks.
    #[doc(hidden)]
    pub fn new(grid: LightGrid, settings: FileSettings, tree: DepthTree) -> Self {
        Self { grid, settings, tree: Arc::new(tree), coarser: Vec::new() }
    }

    /// Adds coarser levels, the finest of them first.
    #[doc(hidden)]
    #[must_use]
    pub fn with_coarser(mut self, levels: impl IntoIterator<Item = (LightGrid, DepthTree)>) -> Self {
        self.coarser.extend(levels.into_iter().map(|(grid, tree)| Level { grid, tree: Arc::new(tree) }));
        self
    }

    /// Returns the number of levels of detail, at least 1. Level 0 is the finest, and each has voxels four
    /// times as large as the one before it.
    pub fn level_count(&self) -> u32 {
        1 + self.coarser.len() as u32
    }

    /// Returns a level as a separate file, with the levels coarser than it. `None` if there is no such level.
    /// The voxels are shared, so this is cheap.
    pub fn level(&self, level: u32) -> Option<Self> {
        if level == 0 {
            return Some(self.clone());
        }
        let at = level as usize - 1;
        let Level { grid, tree } = self.coarser.get(at)?.clone();
        let resolution = self.settings.resolution.div_ceil(LEVEL_STEP.pow(level));
        let settings = FileSettings { resolution, ..self.settings };
        Some(Self { grid, settings, tree, coarser: self.coarser[at + 1..].to_vec() })
    }

    /// Returns the file with positions in the world. Those in the file of a region are relative to the
    /// region's origin; of other files nothing changes. The voxels are shared, so this is cheap.
    #[must_use]
    pub fn in_world(mut self) -> Self {
        if let Some(region) = self.settings.region.take() {
            self.grid = region.in_world(self.grid, 1);
            for (number, level) in (1..).zip(&mut self.coarser) {
                level.grid = region.in_world(level.grid, LEVEL_STEP.pow(number));
            }
        }
        self
    }

    /// Returns all levels, the finest first.
    #[doc(hidden)]
    pub fn levels(&self) -> Vec<Level> {
        let finest = Level { grid: self.grid, tree: Arc::clone(&self.tree) };
        std::iter::once(finest).chain(self.coarser.iter().cloned()).collect()
    }

    /// Returns the sun that the file was baked for.
    pub fn sun(&self) -> Sun {
        self.grid.sun
    }

    /// Whether the bake treated masked materials as opaque.
    pub fn ignores_alpha(&self) -> bool {
        self.settings.ignore_alpha
    }
}

/// Calls `f` with each item, on the threads of the current rayon pool if the feature `rayon` is enabled.
fn each<T: Sync, R: Send>(items: &[T], f: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;

        items.par_iter().map(f).collect()
    }
    #[cfg(not(feature = "rayon"))]
    items.iter().map(f).collect()
}

/// Returns the number of threads that [`each`] uses.
fn threads() -> usize {
    #[cfg(feature = "rayon")]
    {
        rayon::current_num_threads()
    }
    #[cfg(not(feature = "rayon"))]
    1
}
