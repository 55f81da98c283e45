//! Options of the benchmarks.

use std::path::PathBuf;

use clap::{Subcommand, ValueEnum};

use super::render::DeviceArgs;
use super::{BenchPeers, LayoutArg, parse_size};

#[derive(clap::Args)]
pub(crate) struct Bench {
    #[command(subcommand)]
    pub(crate) what: BenchVerb,
}

#[derive(Subcommand)]
pub(crate) enum BenchVerb {
    /// Seconds, memory and bytes by scene, resolution and option; writes bake.md and bake.json. Or, with --suite fast, what the
    /// fast bake is held to; writes fast.md and fast.json; exit code 1 where it does not hold
    #[command(
        after_help = "Example: adumbra bench bake --scenes scenes --resolutions 1024,4096 -o docs/bench\n\n\
        Example: adumbra bench bake --suite fast --only 8192,query --scenes scenes -o docs/bench"
    )]
    Bake(BenchBake),
    /// Every scene against rays, under seven suns and in both layouts; writes verify.md and verify.json
    #[command(after_help = "Example: adumbra bench verify --scenes scenes --resolution 8192 -o docs/bench")]
    Verify(BenchVerify),
    /// The world-aligned tree: builders, reductions, frames, options, filters; writes tree.md, tree.json, plots, pictures
    #[command(after_help = "Example: adumbra bench tree --scenes scenes -o docs/bench")]
    Tree(BenchTree),
    /// The screen-space blur: milliseconds by samples, and its halo and gap; writes blur.md, blur.json, a plot
    #[command(after_help = "Example: adumbra bench blur --size 1280x720 -o docs/bench")]
    Blur(BenchBlur),
    /// Baked voxels and real-time techniques beside the truth, from above and from the street; writes shadows.md and shadows.json
    #[command(after_help = "Example: adumbra bench shadows --scenes scenes --truth truth -o docs/bench")]
    Shadows(BenchShadows),
    /// Every technique on the truth cameras, beside today's engines; writes peers.md and peers.json
    #[command(after_help = "Example: adumbra bench peers --scenes scenes --truth truth -o docs/bench")]
    Peers(BenchPeers),
    /// Hybrid-resolution shadow maps beside plain ones, as in their paper; writes hrsm.md, hrsm.json, pictures
    #[command(after_help = "Example: adumbra bench hrsm --scenes scenes -o docs/bench")]
    Hrsm(BenchHrsm),
    /// Every estimator of ambient occlusion beside rays, on eight scenes; writes ao.md, ao.json, a plot, pictures
    #[command(after_help = "Example: adumbra bench ao --scenes scenes --truth truth -o docs/bench")]
    Ao(BenchAo),
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SuiteArg {
    /// By scene, resolution and option
    Tables,
    /// What the fast bake is held to
    Fast,
}

#[derive(clap::Args)]
pub(crate) struct BenchBake {
    /// Which tables
    #[arg(long, value_enum, default_value = "tables")]
    pub(crate) suite: SuiteArg,
    /// Folder of scenes
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: PathBuf,
    /// Scene files in that folder
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "kaykit_city_21.glb,zdm2.glb,alpine-2.glb,delft.glb,box-city-5k.glb,dragon_202k.ply"
    )]
    pub(crate) names: Vec<String>,
    /// Read files outside the folder too, where those scenes name them; for scenes that you trust
    #[arg(long)]
    pub(crate) allow_outside: bool,
    /// Resolutions
    #[arg(long, value_delimiter = ',', default_value = "1024,2048,4096,8192,16384")]
    pub(crate) resolutions: Vec<u64>,
    /// Resolution of the table that varies the options
    #[arg(long, default_value_t = 8192)]
    pub(crate) variant_resolution: u64,
    /// --suite fast: rows whose name, such as box-city-51k-65536 or query, holds one of these
    #[arg(long, value_name = "TEXT", value_delimiter = ',', num_args = 1..)]
    pub(crate) only: Vec<String>,
    /// --suite fast: leave out rows of a higher resolution
    #[arg(long, value_name = "N")]
    pub(crate) max_n: Option<u64>,
    /// --suite fast: how the files hold the voxels [default: that of bake]
    #[arg(long, value_enum)]
    pub(crate) layout: Option<LayoutArg>,
    /// --suite fast: points of each row compared with rays
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    pub(crate) samples: u64,
    /// Where the tables go
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

#[derive(clap::Args)]
pub(crate) struct BenchVerify {
    /// Folder of scenes
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: PathBuf,
    /// Scene files in that folder
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "zdm2.glb,kaykit_city_21.glb,dragon_202k.ply,armadillo.ply,alpine-2.glb,street-1.glb,delft.glb,bridge_garden.glb,auster.obj,box-city-5k.glb,oak_medium.glb"
    )]
    pub(crate) names: Vec<String>,
    /// Read files outside the folder too, where those scenes name them; for scenes that you trust
    #[arg(long)]
    pub(crate) allow_outside: bool,
    /// Resolution
    #[arg(long, default_value_t = 8192)]
    pub(crate) resolution: u64,
    /// Points for each scene and sun
    #[arg(long, default_value_t = 1_000_000)]
    pub(crate) samples: u64,
    /// Filter widths, a row each
    #[arg(long, value_name = "K,...", value_delimiter = ',', default_value = "1")]
    pub(crate) filter: Vec<u32>,
    /// Points in free space in place of points on surfaces, on files baked with --no-assume-ground
    #[arg(long)]
    pub(crate) volume: bool,
    /// Where the tables go
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

#[derive(clap::Args)]
pub(crate) struct BenchTree {
    /// Folder of scenes
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: PathBuf,
    /// Scene files in that folder; primitives and landscape are made
    #[arg(long, value_delimiter = ',', default_value = "primitives,landscape,zdm2.glb,kaykit_city_21.glb")]
    pub(crate) names: Vec<String>,
    /// Read files outside the folder too, where those scenes name them; for scenes that you trust
    #[arg(long)]
    pub(crate) allow_outside: bool,
    /// Depths of the builders' tables
    #[arg(long, value_delimiter = ',', default_value = "8,9,10,11,12",
        value_parser = clap::value_parser!(u32).range(3..=14))]
    pub(crate) depths: Vec<u32>,
    /// Runs that a median is taken of
    #[arg(long, default_value_t = 9, value_parser = runs)]
    pub(crate) runs: usize,
    /// Points compared with rays
    #[arg(long, default_value_t = 200_000)]
    pub(crate) samples: u64,
    /// Measure these sections only, and keep the others of an earlier tree.json
    #[arg(long, value_delimiter = ',', value_parser = ["builders", "reductions", "frames", "options", "filters"])]
    pub(crate) only: Vec<String>,
    /// Where tables, plots and pictures go
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

#[derive(clap::Args)]
pub(crate) struct BenchBlur {
    /// Samples along a line
    #[arg(long, value_delimiter = ',', default_value = "8,16,24,32,48,64",
        value_parser = clap::value_parser!(u32).range(8..=64))]
    pub(crate) samples: Vec<u32>,
    /// Runs that a median is taken of
    #[arg(long, default_value_t = 5, value_parser = runs)]
    pub(crate) runs: usize,
    /// Pixels
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = parse_size)]
    pub(crate) size: [u32; 2],
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
    /// Where tables and the plot go
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

fn runs(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| (1..=99).contains(n)).ok_or_else(|| "give a number from 1 to 99".to_owned())
}

#[derive(clap::Args)]
pub(crate) struct BenchShadows {
    /// Folder of scenes
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: PathBuf,
    /// Folder of truth files, whose cameras and suns are used
    #[arg(long, value_name = "DIR")]
    pub(crate) truth: PathBuf,
    /// Scenes, without their endings
    #[arg(long, value_delimiter = ',', default_value = "zdm2,kaykit_city_21,alpine-2,auster")]
    pub(crate) names: Vec<String>,
    /// Techniques to compare, as for render
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "voxel:filter=1,csm:filter=1,voxel:filter=5,csm:filter=5,voxel:filter=9,voxel-cubes,sm,pcf,pcss,vsm,evsm,msm,csm-vsm,csm-evsm,blur,blur-bilateral"
    )]
    pub(crate) shadow: Vec<String>,
    /// Texels on the longest side of the light-aligned files
    #[arg(long, value_name = "N", default_value_t = 16384)]
    pub(crate) resolution: u64,
    /// Voxels a side of the world-aligned files
    #[arg(long, value_name = "N", default_value_t = 2048)]
    pub(crate) cube_resolution: u64,
    /// The scene whose costs are compared
    #[arg(long, value_name = "NAME", default_value = "kaykit_city_121")]
    pub(crate) cost_scene: String,
    /// The techniques whose costs are compared there
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "voxel:filter=9,csm:filter=5,csm:filter=5:static=cached"
    )]
    pub(crate) cost_shadow: Vec<String>,
    /// Frames that times are medians of
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub(crate) frames: u32,
    /// Frames of the path that shimmer is measured along
    #[arg(long, value_name = "N", default_value_t = 12)]
    pub(crate) path_frames: u32,
    /// Pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = super::parse_size)]
    pub(crate) size: [u32; 2],
    #[command(flatten)]
    pub(crate) device: super::DeviceArgs,
    #[command(flatten)]
    pub(crate) cache: super::CacheArgs,
    /// Where the tables go
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

#[derive(clap::Args)]
pub(crate) struct BenchHrsm {
    /// Folder of scenes, for dragon_202k, bunny_69k and oak_medium
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: PathBuf,
    /// Resolutions that maps start from
    #[arg(long, value_delimiter = ',', default_value = "1024,2048,4096", value_parser = start)]
    pub(crate) starts: Vec<u32>,
    /// These models only; wires is a figure's
    #[arg(long, value_delimiter = ',', num_args = 1..,
        value_parser = ["dragon", "bunny", "ball", "spheres", "oak", "wires"])]
    pub(crate) only: Vec<String>,
    /// Frames that times are medians of
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = frames)]
    pub(crate) frames: u32,
    /// Pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = super::parse_size)]
    pub(crate) size: [u32; 2],
    #[command(flatten)]
    pub(crate) device: super::DeviceArgs,
    #[command(flatten)]
    pub(crate) cache: super::CacheArgs,
    /// Where tables and pictures go
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

#[derive(clap::Args)]
pub(crate) struct BenchAo {
    /// Folder of scenes: dragon_202k, bunny_69k, armadillo, dream_apartment, zdm2, kaykit_city_21, bridge_garden, box-city-5k
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: PathBuf,
    /// Folder of truth files, for the table beside today's engines [default: it is left out]
    #[arg(long, value_name = "DIR")]
    pub(crate) truth: Option<PathBuf>,
    /// These scenes only
    #[arg(long, value_delimiter = ',', num_args = 1.., value_parser = ["dragon", "bunny", "armadillo",
        "dream_apartment", "zdm2", "kaykit_city_21", "bridge_garden", "cornell"])]
    pub(crate) only: Vec<String>,
    /// Frames that times are medians of
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = frames)]
    pub(crate) frames: u32,
    /// Pixels of the still pictures; those of the path have half the width and height
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = super::parse_size)]
    pub(crate) size: [u32; 2],
    /// Rays a pixel of the truth
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub(crate) rays: u32,
    #[command(flatten)]
    pub(crate) device: super::DeviceArgs,
    #[command(flatten)]
    pub(crate) cache: super::CacheArgs,
    /// Where tables, the plot and pictures go
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

fn start(text: &str) -> Result<u32, String> {
    let known = |n: &u32| [1024, 2048, 4096, 8192].contains(n);
    text.parse().ok().filter(known).ok_or_else(|| "give 1024, 2048, 4096 or 8192".to_owned())
}

fn frames(text: &str) -> Result<u32, String> {
    text.parse().ok().filter(|n| (1..=99).contains(n)).ok_or_else(|| "give a number from 1 to 99".to_owned())
}
