//! The papers' techniques: `voxel-dag`, which reads a graph of 2014, and `voxel-cubes` and `voxel-texture`,
//! which read a tree of 2021.
//!
//! A program adds [`TECHNIQUES`] to its list with `Techniques::product().with(TECHNIQUES)`, and gives the
//! files as `TechniqueFiles::other`: a [`PaperFiles`].

mod cubes;
mod errors;
mod files;
mod graph;
mod options;
mod pages;
pub mod shaders;
#[cfg(test)]
mod tests;

use adumbra_render::technique::{SpecReader, Technique};
use adumbra_render::techniques::{Design, Role, TechniqueEntry, TechniqueSpec, Traits};
use adumbra_render::{Gpu, Reads, Result, TechniqueFiles};

pub use cubes::Cubes;
pub use files::{GRAPH_FILE, PaperFiles, TREE_FILE};
pub use graph::{Graph, GraphSettings, look_up_of, words};
pub use options::{CubesOptions, CubesStore};
pub use pages::{PageTexture, PagesError};

/// The techniques of this crate.
pub const TECHNIQUES: &[TechniqueEntry] = &[
    TechniqueEntry {
        name: "voxel-dag",
        summary: "a graph file, filtered over texels",
        role: Role::Shadows,
        design: &OfGraph,
    },
    TechniqueEntry {
        name: "voxel-cubes",
        summary: "a world-aligned file, filtered over voxels",
        role: Role::Shadows,
        design: &Tree { from_texture: false },
    },
    TechniqueEntry {
        name: "voxel-texture",
        summary: "a world-aligned file, read from an RGBA8 texture",
        role: Role::Shadows,
        design: &Tree { from_texture: true },
    },
];

#[derive(Debug)]
struct OfGraph;

impl Design for OfGraph {
    fn traits(&self, _spec: &TechniqueSpec) -> Traits {
        Traits { reads: Reads::Other(GRAPH_FILE), shows_movers: false, ..Traits::DRAWN }
    }

    fn read(&self, reader: &mut SpecReader<'_>, baked: TechniqueFiles<'_>) -> Result<()> {
        let file = PaperFiles::among(baked).and_then(|files| files.graph.as_ref());
        GraphSettings::from_reader(reader, file).map(drop)
    }

    fn build(
        &self,
        gpu: &Gpu,
        spec: &TechniqueSpec,
        baked: TechniqueFiles<'_>,
    ) -> Result<Box<dyn Technique>> {
        let file = PaperFiles::among(baked).and_then(|files| files.graph.as_ref());
        Ok(Box::new(Graph::from_spec(gpu, spec.text(), file)?))
    }
}

#[derive(Debug)]
struct Tree {
    from_texture: bool,
}

impl Design for Tree {
    fn traits(&self, _spec: &TechniqueSpec) -> Traits {
        Traits { reads: Reads::Other(TREE_FILE), shows_movers: false, ..Traits::DRAWN }
    }

    fn read(&self, reader: &mut SpecReader<'_>, baked: TechniqueFiles<'_>) -> Result<()> {
        let file = PaperFiles::among(baked).and_then(|files| files.tree.as_ref());
        CubesOptions::from_reader(reader, file, self.from_texture).map(drop)
    }

    fn build(
        &self,
        gpu: &Gpu,
        spec: &TechniqueSpec,
        baked: TechniqueFiles<'_>,
    ) -> Result<Box<dyn Technique>> {
        let file = PaperFiles::among(baked).and_then(|files| files.tree.as_ref());
        Ok(Box::new(Cubes::from_spec(gpu, spec.text(), file, self.from_texture)?))
    }
}
