//! Arguments of `dag`: the graphs of the 2014 paper.

use std::path::PathBuf;

use adumbra::{Bounds, Sun};
use adumbra_bake::{AssumeGround, BakeOptions, ColumnBuilder, FrameChoice, Size};
use adumbra_papers::dag::DagLayout;
use adumbra_papers::dag::build::DagOptions;
use adumbra_program::args::{RunArgs, SceneArgs, SunArgs, parse_bounds};
use adumbra_program::progress::Style;
use adumbra_program::query::Query;
use adumbra_program::verify::Verify;
use clap::{Subcommand, ValueEnum};

/// What `adumbra-lab dag` does.
#[derive(Subcommand)]
pub enum DagVerb {
    /// Bake a scene's sun shadows into a graph
    #[command(
        after_help = "Example: adumbra-lab dag bake city.glb --resolution 8192 --layout plain -o city.adumdag"
    )]
    Bake(Box<DagBake>),
    /// Print what a graph file contains
    #[command(after_help = "Example: adumbra-lab dag info city.adumdag --json")]
    Info(DagInfo),
    /// Compare a graph file's answers with rays at random points; exit code 1 if a promise is missed
    #[command(after_help = "Example: adumbra-lab dag verify city.adumdag --scene city.glb --samples 1000000")]
    Verify(Verify),
    /// Look up the visibility of points in a graph file
    #[command(after_help = "Points, normals and answers as for adumbra query.\n\n\
        Example: adumbra-lab dag query city.adumdag --points p.f32 --normals n.f32 --filter 9 -o v.f32")]
    Query(Query),
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum LayoutArg {
    /// Voxels in 16-bit units: about a third of the bytes of plain
    Packed,
    /// Voxels in 32-bit words
    Plain,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum FrameArg {
    /// As adumbra bake chooses it
    Auto,
    /// Columns along the light, in a plane across it
    Light,
    /// Columns along the light, over level ground
    Oblique,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum BuilderArg {
    /// Draw only blocks that silhouettes cross
    Fast,
    /// Draw every texel
    Plain,
}

/// Arguments of `dag bake`.
#[derive(clap::Args)]
pub struct DagBake {
    /// Scene: .glb, .gltf, .obj or .ply
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) sun: SunArgs,
    /// Texels on the longest side: a power of two
    #[arg(long, value_name = "N", default_value_t = 8192)]
    resolution: u64,
    /// How the file stores the voxels
    #[arg(long, value_enum, default_value = "packed")]
    layout: LayoutArg,
    /// How the voxels lie in the world
    #[arg(long, value_enum, default_value = "auto")]
    frame: FrameArg,
    /// How the columns are found; the result is the same
    #[arg(long, value_enum, default_value = "fast")]
    builder: BuilderArg,
    /// Keep shadows below the last surface of a column too
    #[arg(long)]
    no_assume_ground: bool,
    /// Answer points inside closed solids too
    #[arg(long)]
    no_closed_regions: bool,
    /// Cover this box instead of the scene
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1", allow_hyphen_values = true, value_parser = parse_bounds)]
    bounds: Option<Bounds>,
    #[command(flatten)]
    pub(crate) load: SceneArgs,
    /// The graph file to write [default: the scene's path with the extension .adumdag]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// How to show progress
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) progress: Style,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

impl DagBake {
    /// Returns the options of the bake.
    pub(crate) fn options(&self, sun: Sun, max_memory_bytes: Option<u64>) -> DagOptions {
        let bake = BakeOptions::new(sun, Size::Resolution(self.resolution)).with(|o| {
            o.frame = match self.frame {
                FrameArg::Auto => FrameChoice::Auto,
                FrameArg::Light => FrameChoice::Light,
                FrameArg::Oblique => FrameChoice::Oblique,
            };
            o.builder = match self.builder {
                BuilderArg::Fast => ColumnBuilder::Fast,
                BuilderArg::Plain => ColumnBuilder::Plain,
            };
            o.assume_ground = if self.no_assume_ground { AssumeGround::No } else { AssumeGround::Auto };
            o.closed_regions = !self.no_closed_regions;
            o.ignore_alpha = self.load.ignore_alpha;
            o.bounds = self.bounds;
            o.max_memory_bytes = max_memory_bytes;
        });
        let layout = match self.layout {
            LayoutArg::Packed => DagLayout::Packed,
            LayoutArg::Plain => DagLayout::Plain,
        };
        DagOptions { bake, layout }
    }
}

/// Arguments of `dag info`.
#[derive(clap::Args)]
pub struct DagInfo {
    /// Graph file
    pub(crate) file: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}
