//! Arguments of `compare` and `render`, which are those of `adumbra`, and of the files that the papers'
//! techniques read.

use adumbra_compare::baked::{BakedFiles, MoreFiles};
use adumbra_compare::verbs;
use adumbra_papers::techniques::PaperFiles;

/// The resolution of a tree file that is baked as needed.
#[derive(clap::Args)]
pub struct CubeArgs {
    /// Resolution of a world-aligned file that is baked as needed: voxels along the cube's side
    #[arg(long, value_name = "N", default_value_t = PaperFiles::CUBE_RESOLUTION)]
    pub(crate) cube_resolution: u64,
}

impl CubeArgs {
    /// Returns an empty set of the papers' files.
    pub fn more_files(&self) -> Box<dyn MoreFiles> {
        Box::new(PaperFiles { cube_resolution: self.cube_resolution, ..PaperFiles::default() })
    }

    /// Returns an empty set of all files.
    pub(crate) fn files(&self) -> BakedFiles {
        BakedFiles::with(Some(self.more_files()))
    }
}

/// Arguments of `compare`.
#[derive(clap::Args)]
pub struct Compare {
    /// Those of `adumbra compare`.
    #[command(flatten)]
    pub compare: verbs::compare::Compare,
    /// The tree's resolution.
    #[command(flatten)]
    pub cube: CubeArgs,
}

/// Arguments of `render`.
#[derive(clap::Args)]
pub struct Render {
    /// Those of `adumbra render`.
    #[command(flatten)]
    pub render: verbs::render::Render,
    /// The tree's resolution.
    #[command(flatten)]
    pub cube: CubeArgs,
}
