//! The baked files that voxel techniques look up in: given, or baked on the way.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use adumbra::bake::{Options, Size, bake, bake_hierarchy};
use adumbra::format::{AnyFile, ShadowFile, TreeBody, TreeFile};
use adumbra::light::Sun;
use adumbra::scene::Scene;
use adumbra::tree::{TreeOptions, bake_tree};
use adumbra_lab::report::BakedFigures;
use adumbra_render::{Baked, TechniqueSpec};

use super::lookup::sun_of;
use crate::exit::Failure;
use crate::output::note_input;

/// At most one file of each kind.
#[derive(Default)]
pub(super) struct BakedFiles {
    pub(super) light: Option<ShadowFile>,
    pub(super) tree: Option<TreeFile>,
}

/// How files are baked on the way.
pub(super) struct BakeOnTheWay<'a> {
    pub(super) scene: &'a Scene,
    pub(super) sun: Sun,
    pub(super) ignore_alpha: bool,
    pub(super) resolution: u64,
    pub(super) cube_resolution: u64,
    pub(super) max_memory_bytes: Option<u64>,
}

impl BakedFiles {
    /// Reads the files; two of one kind, or of different suns, are refused.
    pub(super) fn read(paths: &[PathBuf]) -> Result<Self, Failure> {
        let mut files = Self::default();
        let mut sun = None;
        for path in paths {
            note_input("the shadow file itself", path);
            let file = AnyFile::read(path)?;
            let other = sun.replace(sun_of(&file));
            if other.is_some_and(|other| Some(other) != sun) {
                return Err(Failure::Usage(
                    "--shadow-file: the files were baked for different suns".to_owned(),
                ));
            }
            let twice = match file {
                AnyFile::Light(file) => files.light.replace(file).is_some(),
                AnyFile::Tree(file) => files.tree.replace(file).is_some(),
            };
            if twice {
                return Err(Failure::Usage(
                    "--shadow-file: give at most one light-aligned and one world-aligned file".to_owned(),
                ));
            }
        }
        Ok(files)
    }

    /// The sun that the files were baked for.
    pub(super) fn sun(&self) -> Option<Sun> {
        self.light.as_ref().map(|f| f.grid.sun).or_else(|| self.tree.as_ref().map(|f| f.sun))
    }

    /// Whether a file took masked materials as opaque.
    pub(super) fn ignore_alpha(&self) -> bool {
        self.light.as_ref().is_some_and(|f| f.settings.ignore_alpha)
            || self.tree.as_ref().is_some_and(|f| f.settings.ignore_alpha)
    }

    /// Bakes what `specs` need and is not there yet.
    pub(super) fn complete(
        &mut self,
        specs: &[TechniqueSpec],
        how: &BakeOnTheWay<'_>,
    ) -> Result<(), Failure> {
        let never = AtomicBool::new(false);
        if self.light.is_none() && specs.iter().any(needs_light) {
            let options = Options {
                ignore_alpha: how.ignore_alpha,
                max_memory_bytes: how.max_memory_bytes,
                ..Options::new(how.sun, Size::Resolution(how.resolution))
            };
            self.light = Some(if specs.iter().any(TechniqueSpec::needs_hierarchy) {
                let baked = bake_hierarchy(how.scene, &options, true, &|_| {}, &never)?;
                ShadowFile::hierarchy(baked.grid, baked.settings, baked.hierarchy)
            } else {
                let baked = bake(how.scene, &options, &|_| {}, &never)?;
                ShadowFile::plain(baked.grid, baked.settings, baked.dag)
            });
        }
        if self.tree.is_none() && specs.iter().any(needs_tree) {
            let options = TreeOptions {
                ignore_alpha: how.ignore_alpha,
                ..TreeOptions::new(how.sun, Size::Resolution(how.cube_resolution))
            };
            let baked = bake_tree(how.scene, &options, &|_| {}, &never)?;
            self.tree = Some(TreeFile {
                space: baked.space,
                sun: how.sun,
                settings: baked.settings,
                regions: baked.regions,
                body: TreeBody::Words(baked.tree),
                attribute: Vec::new(),
                attribute_kind: None,
            });
        }
        Ok(())
    }

    /// As techniques take them.
    pub(super) fn baked(&self) -> Baked<'_> {
        Baked { light: self.light.as_ref(), tree: self.tree.as_ref() }
    }

    /// For the report.
    pub(super) fn figures(&self) -> Vec<BakedFigures> {
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

fn needs_light(spec: &TechniqueSpec) -> bool {
    matches!(spec.innermost().name(), "voxel" | "voxel+csm")
}

fn needs_tree(spec: &TechniqueSpec) -> bool {
    spec.innermost().name().starts_with("voxel-")
}
