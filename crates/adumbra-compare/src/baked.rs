//! The baked files that voxel techniques sample: given, or baked on demand.

use std::path::PathBuf;

use adumbra::{ShadowFile, Sun};
use adumbra_bake::{BakeOptions, Size, Watch, bake};
use adumbra_program::exit::Failure;
use adumbra_program::output::note_input;
use adumbra_render::{Baked, Reads, TechniqueSpec};
use adumbra_scene::Scene;
use adumbra_tree::{AnyFile, TreeFile, TreeOptions, bake_tree};

use crate::Result;
use crate::report::BakedFigures;

/// The baked files of a comparison, at most one of each kind.
#[derive(Default)]
pub struct BakedFiles {
    /// The light-aligned file.
    pub light: Option<ShadowFile>,
    /// The world-aligned file.
    pub tree: Option<TreeFile>,
}

/// Options of bakes on demand.
pub struct BakeOnDemand<'a> {
    /// The scene to bake.
    pub scene: &'a Scene,
    /// The sun.
    pub sun: Sun,
    /// Whether alpha-masked materials count as opaque.
    pub ignore_alpha: bool,
    /// Texels along the longest side of a light-aligned file.
    pub resolution: u64,
    /// Voxels along each side of a world-aligned file.
    pub cube_resolution: u64,
    /// Memory limit of a bake in bytes.
    pub max_memory_bytes: Option<u64>,
}

impl BakedFiles {
    /// Reads the files.
    ///
    /// # Errors
    ///
    /// Returns an error if a file cannot be read, if two files are of one kind, or if they have different suns.
    pub fn read(paths: &[PathBuf]) -> Result<Self> {
        let mut files = Self::default();
        let mut sun = None;
        for path in paths {
            note_input("the shadow file itself", path);
            let file = AnyFile::read(path)?;
            let other = sun.replace(match &file {
                AnyFile::Light(file) => file.grid.sun,
                AnyFile::Tree(file) => file.sun,
            });
            if other.is_some_and(|other| Some(other) != sun) {
                return Err(Failure::Usage(
                    "--shadow-file: the files were baked for different suns".to_owned(),
                )
                .into());
            }
            let twice = match file {
                AnyFile::Light(file) => files.light.replace(file).is_some(),
                AnyFile::Tree(file) => files.tree.replace(file).is_some(),
            };
            if twice {
                return Err(Failure::Usage(
                    "--shadow-file: give at most one light-aligned and one world-aligned file".to_owned(),
                )
                .into());
            }
        }
        Ok(files)
    }

    /// Returns the sun that the files were baked for, or `None` without files.
    pub fn sun(&self) -> Option<Sun> {
        self.light.as_ref().map(|f| f.grid.sun).or_else(|| self.tree.as_ref().map(|f| f.sun))
    }

    /// Whether a file was baked with alpha-masked materials as opaque.
    pub fn ignore_alpha(&self) -> bool {
        self.light.as_ref().is_some_and(|f| f.settings.ignore_alpha)
            || self.tree.as_ref().is_some_and(|f| f.settings.ignore_alpha)
    }

    /// Prints to stderr what [`BakedFiles::complete`] is about to bake.
    pub fn announce(&self, specs: &[TechniqueSpec], how: &BakeOnDemand<'_>) {
        if self.lacks_light(specs) {
            eprintln!(
                "note: no light-aligned --shadow-file; baking one with {} texels along its longest side",
                how.resolution
            );
        }
        if self.lacks_tree(specs) {
            let side = how.cube_resolution;
            eprintln!("note: no world-aligned --shadow-file; baking one with {side} voxels per side");
        }
    }

    fn lacks_light(&self, specs: &[TechniqueSpec]) -> bool {
        self.light.is_none() && specs.iter().any(|s| s.reads().is_light_file())
    }

    fn lacks_tree(&self, specs: &[TechniqueSpec]) -> bool {
        self.tree.is_none() && specs.iter().any(|s| s.reads() == Reads::TreeFile)
    }

    /// Bakes the files that `specs` need and that are missing.
    ///
    /// # Errors
    ///
    /// Returns an error if a bake fails.
    pub fn complete(&mut self, specs: &[TechniqueSpec], how: &BakeOnDemand<'_>) -> Result<()> {
        if self.lacks_light(specs) {
            let options = BakeOptions {
                ignore_alpha: how.ignore_alpha,
                max_memory_bytes: how.max_memory_bytes,
                ..BakeOptions::new(how.sun, Size::Resolution(how.resolution))
            };
            self.light = Some(bake(how.scene, &options, Watch::none())?.file);
        }
        if self.lacks_tree(specs) {
            let options = TreeOptions {
                ignore_alpha: how.ignore_alpha,
                max_memory_bytes: how.max_memory_bytes,
                ..TreeOptions::new(how.sun, Size::Resolution(how.cube_resolution))
            };
            self.tree = Some(bake_tree(how.scene, &options, Watch::none())?.into());
        }
        Ok(())
    }

    /// Returns the files in the form that techniques take.
    pub fn baked(&self) -> Baked<'_> {
        Baked { light: self.light.as_ref(), tree: self.tree.as_ref() }
    }

    /// Returns the figures of the files for the report.
    pub fn figures(&self) -> Vec<BakedFigures> {
        let light = self.light.as_ref().map(|f| BakedFigures {
            frame: "light".to_owned(),
            resolution: f.settings.resolution.into(),
            voxel_size: f.grid.voxel_size,
            file_bytes: f.encoded_len(),
        });
        let tree = self.tree.as_ref().map(|f| BakedFigures {
            frame: "world".to_owned(),
            resolution: f.space.side_voxels().into(),
            voxel_size: f.space.voxel_size,
            file_bytes: f.encode().len() as u64,
        });
        light.into_iter().chain(tree).collect()
    }
}
