//! A bake with the limits, the cache and the progress of `adumbra bake`.

use std::path::Path;
use std::sync::Arc;

use adumbra_bake::{BakeCache, BakeOptions, BakeSummary};
use adumbra_files::StagedFile;
use adumbra_program::exit::Failure;
use adumbra_program::memory::{Guard, Share};
use adumbra_program::progress::{Reporter, Units};
use adumbra_scene::Scene;

use crate::args::Bake;

/// Bakes of a scene by the options of `bake`.
pub(super) struct Baking<'a> {
    pub(super) args: &'a Bake,
    pub(super) scene: &'a Scene,
    pub(super) cache: Option<&'a Arc<dyn BakeCache>>,
    pub(super) share: &'a Share,
}

impl Baking<'_> {
    /// Bakes a file that takes the place of `output` when it is placed, and shows the progress.
    pub(super) fn file(
        &self,
        options: &BakeOptions,
        output: &Path,
    ) -> Result<(StagedFile, BakeSummary), Failure> {
        let guard = Guard::new(self.args.run.memory_limit());
        let reporter = Reporter::new(self.args.progress, Units::TEXELS);
        let progress = |p| {
            guard.look();
            reporter.update(p);
        };
        let bake = adumbra_bake::Bake::with_options(self.scene, options)
            .on_progress(progress)
            .cancel(guard.cancel());
        let bake = match self.cache {
            Some(cache) => bake.cache(Arc::clone(cache)),
            None => bake,
        };
        guard.end("the bake", self.share, bake.stage(output))
    }
}
