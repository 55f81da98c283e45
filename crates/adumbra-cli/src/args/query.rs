//! Arguments of `query`.

use std::path::{Path, PathBuf};

use adumbra_program::args::RunArgs;

use super::LookupArgs;

#[derive(clap::Args)]
pub(crate) struct Query {
    /// Shadow file
    pub(crate) file: PathBuf,
    /// World-space points as little-endian float32 triples
    #[arg(long, value_name = "FILE", required_unless_present = "points_f64", conflicts_with = "points_f64")]
    points: Option<PathBuf>,
    /// World-space points as little-endian float64 triples: far from the origin float32 would round them to whole
    /// voxels
    #[arg(long, value_name = "FILE")]
    pub(crate) points_f64: Option<PathBuf>,
    /// Unit normals as little-endian float32 triples, one per point; the slope bias and the filter's plane need them
    #[arg(long, value_name = "FILE")]
    pub(crate) normals: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) lookup: LookupArgs,
    /// Also write the width of the sun's penumbra in metres: one little-endian float32 per point, NaN away from shadow
    /// borders; for files baked with --attribute penumbra
    #[arg(long, value_name = "FILE")]
    pub(crate) penumbra: Option<PathBuf>,
    /// The file for the visibilities: one little-endian float32 per point
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

impl Query {
    /// Returns the file of points, whichever format was given.
    pub(crate) fn points_path(&self) -> &Path {
        self.points_f64.as_deref().or(self.points.as_deref()).unwrap_or(Path::new(""))
    }
}
