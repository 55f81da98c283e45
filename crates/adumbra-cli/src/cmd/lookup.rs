//! Look-ups in files of either frame.

use adumbra::{PointVisibility, Query, ShadowFile};
use adumbra_program::exit::Failure;
use adumbra_tree::query::{TreeQuery, Weights};
use adumbra_tree::{AnyFile, TreeBody, TreeFile, Voxels};

use crate::args::{BiasArgs, LookupArgs};

/// Parameters of a look-up.
pub(super) struct LookupOptions<'a> {
    pub(super) bias: &'a BiasArgs,
    /// Width in texels for a light-aligned file, voxels per side for a world-aligned file.
    pub(super) filter: u32,
    pub(super) weights: Weights,
}

impl<'a> From<&'a LookupArgs> for LookupOptions<'a> {
    fn from(args: &'a LookupArgs) -> Self {
        Self { bias: &args.bias, filter: args.filter, weights: args.weights.into() }
    }
}

impl LookupOptions<'_> {
    /// Returns the look-up of a file.
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
        Ok(Query::new(&file.grid, file.leaf_masks(), self.bias.over(file.settings.bias)?, self.filter)?)
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
