//! Shadow files that are written as they are made.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

use adumbra_bake::{BakeCache, BakeOptions, BakeSummary, Error, Watch, bake_to, bake_with_cache};
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
        let baked = staged(output, |out| {
            let watch = Watch::new(&progress, guard.cancel());
            match self.cache {
                Some(cache) => bake_with_cache(self.scene, options, cache, watch, out),
                None => bake_to(self.scene, options, watch, out),
            }
        });
        guard.end("the bake", self.share, baked)
    }
}

/// Writes a shadow file that takes the place of `output` when it is placed.
pub(super) fn staged(
    output: &Path,
    write: impl FnOnce(&mut File) -> adumbra_bake::Result<BakeSummary>,
) -> Result<(StagedFile, BakeSummary), Failure> {
    let mut outcome = None;
    let staged = StagedFile::new(output, |out| match write(out) {
        Ok(written) => {
            let bytes = written.bytes;
            outcome = Some(Ok(written));
            Ok(bytes)
        }
        Err(Error::Output(error)) => Err(error),
        Err(error) => {
            outcome = Some(Err(error));
            Err(io::Error::other("the file was not finished"))
        }
    });
    match (staged, outcome) {
        (Ok(staged), Some(Ok(written))) => Ok((staged, written)),
        // What stopped the work says more than that its file is not complete.
        (_, Some(Err(error))) => Err(error.into()),
        (Err(error), _) => Err(error.into()),
        (Ok(_), None) => unreachable!("a file that is staged has been written"),
    }
}
