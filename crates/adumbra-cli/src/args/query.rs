//! Arguments of `query`.

use std::path::{Path, PathBuf};

use super::{BiasArgs, WeightsArg, WorkArgs};

#[derive(clap::Args)]
pub(crate) struct Query {
    /// Shadow file
    pub(crate) file: PathBuf,
    /// World points: little-endian float32 triples
    #[arg(long, value_name = "FILE", required_unless_present = "points_f64", conflicts_with = "points_f64")]
    points: Option<PathBuf>,
    /// World points as little-endian float64 triples: far from the origin float32 rounds them to whole voxels
    #[arg(long, value_name = "FILE")]
    pub(crate) points_f64: Option<PathBuf>,
    /// Unit normals, one a point: the slope's bias and the filter's plane need them
    #[arg(long, value_name = "FILE")]
    pub(crate) normals: Option<PathBuf>,
    /// Filter width in texels: 1, 3, 5, 9 or 17; of a world-aligned file K × K × K voxels: 1, 3 or 5
    #[arg(long, value_name = "K", default_value_t = 1)]
    pub(crate) filter: u32,
    /// How a world-aligned file's taps are weighted
    #[arg(long, value_enum, default_value = "mean")]
    pub(crate) weights: WeightsArg,
    #[command(flatten)]
    pub(crate) bias: BiasArgs,
    /// Also write the width of the sun's penumbra, metres: one little-endian float32 a point, NaN away from shadow borders;
    /// for files baked with --attribute penumbra
    #[arg(long, value_name = "FILE")]
    pub(crate) penumbra: Option<PathBuf>,
    /// Where the visibilities go: one little-endian float32 a point
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

impl Query {
    /// The file of points, whichever kind was given.
    pub(crate) fn points_path(&self) -> &Path {
        self.points_f64.as_deref().or(self.points.as_deref()).unwrap_or(Path::new(""))
    }
}
