//! Points answered from whichever kind of file.

use adumbra::format::{AnyFile, ShadowFile, TreeBody, TreeFile};
use adumbra::light::Sun;
use adumbra::query::{PointVisibility, Query, TreeQuery, Weights};
use adumbra::tree::Voxels;

use crate::args::BiasArgs;
use crate::exit::Failure;

/// How a file is asked.
pub(super) struct Asking<'a> {
    pub(super) bias: &'a BiasArgs,
    /// Texels, or voxels a side.
    pub(super) filter: u32,
    pub(super) weights: Weights,
}

impl Asking<'_> {
    /// The look-up of a file.
    pub(super) fn lookup<'f>(&self, file: &'f AnyFile) -> Result<Box<dyn PointVisibility + 'f>, Failure> {
        Ok(match file {
            AnyFile::Light(file) => Box::new(self.light(file)?),
            AnyFile::Tree(file) => match &file.body {
                TreeBody::Words(tree) => Box::new(self.tree(file, tree)?),
                TreeBody::Symmetric(tree) => Box::new(self.tree(file, tree)?),
            },
        })
    }

    pub(super) fn light<'f>(&self, file: &'f ShadowFile) -> Result<Query<'f>, Failure> {
        if self.weights != Weights::Mean {
            return Err(Failure::Usage(
                "--weights is for world-aligned files; this one is light-aligned".to_owned(),
            ));
        }
        Ok(Query::new(&file.grid, file.slabs(), self.bias.over(file.settings.bias)?, self.filter)?)
    }

    pub(super) fn tree<'f, T: Voxels>(
        &self,
        file: &TreeFile,
        tree: &'f T,
    ) -> Result<TreeQuery<'f, T>, Failure> {
        let bias = self.bias.over(file.settings.bias)?;
        let regions = &file.regions;
        Ok(TreeQuery::new(&file.space, regions, &file.sun, tree, bias, self.filter, self.weights)?)
    }
}

/// The sun that a file was baked for.
pub(super) fn sun_of(file: &AnyFile) -> Sun {
    match file {
        AnyFile::Light(file) => file.grid.sun,
        AnyFile::Tree(file) => file.sun,
    }
}

/// Whether the bake took masked materials as opaque.
pub(super) fn ignored_alpha(file: &AnyFile) -> bool {
    match file {
        AnyFile::Light(file) => file.settings.ignore_alpha,
        AnyFile::Tree(file) => file.settings.ignore_alpha,
    }
}
