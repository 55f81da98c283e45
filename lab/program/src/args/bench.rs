//! Options of the benchmarks.

use std::path::PathBuf;

use adumbra_program::args::parse_size;
use clap::{Subcommand, ValueEnum};

use super::CubeArgs;

use adumbra_compare::args::{CacheArgs, DeviceArgs, ResolutionArgs};

/// The benchmarks, with their options.
#[derive(Subcommand)]
pub enum BenchVerb {
    /// Time, memory and file size of bakes by scene, resolution and option; writes bake.md and bake.json.
    /// With --suite fast: the requirements on the fast bake; writes fast.md and fast.json; exit code 1 if one
    /// is not met
    #[command(
        after_help = "Example: adumbra-lab bench bake --scenes scenes --resolutions 1024,4096 -o docs/bench\n\n\
        Example: adumbra-lab bench bake --suite fast --only 8192,query --scenes scenes -o docs/bench"
    )]
    Bake(BenchBake),
    /// Every scene checked against rays, under seven suns and in the layouts packed and depths; writes
    /// verify.md and verify.json
    #[command(
        after_help = "Example: adumbra-lab bench verify --scenes scenes --resolution 8192 -o docs/bench"
    )]
    Verify(BenchVerify),
    /// The world-aligned tree: builders, reductions, frames, options, filters; writes tree.md, tree.json,
    /// plots and pictures
    #[command(after_help = "Example: adumbra-lab bench tree --scenes scenes -o docs/bench")]
    Tree(BenchTree),
    /// The screen-space blur: milliseconds by sample count, and its halo and gap; writes blur.md, blur.json
    /// and a plot
    #[command(after_help = "Example: adumbra-lab bench blur --size 1280x720 -o docs/bench")]
    Blur(BenchBlur),
    /// Baked voxels and real-time techniques compared with ray-traced truth, from above and at street level;
    /// writes shadows.md and shadows.json
    #[command(after_help = "Example: adumbra-lab bench shadows --scenes scenes --truth truth -o docs/bench")]
    Shadows(BenchShadows),
    /// What baked look-ups read: words per pixel, and sectors of 32 bytes per group of 8 × 4 pixels, by
    /// scene, view, frame, layout and filter; writes lookup.md and lookup.json
    #[command(after_help = "Example: adumbra-lab bench lookup --scenes scenes --truth truth -o docs/bench")]
    Lookup(BenchLookup),
    /// Every technique's passes on the GPU at hand, in generated scenes: filters, frames, layouts,
    /// resolutions, hybrid maps, ambient occlusion, and a large city; writes gpu-ADAPTER.md and
    /// gpu-ADAPTER.json
    #[command(after_help = "Example: adumbra-lab bench gpu -o docs/bench")]
    Gpu(BenchGpu),
    /// Every technique at the truth cameras, compared with current engines; writes peers.md and peers.json
    #[command(after_help = "Example: adumbra-lab bench peers --scenes scenes --truth truth -o docs/bench")]
    Peers(BenchPeers),
    /// Hybrid-resolution shadow maps compared with plain ones, as in their paper; writes hrsm.md, hrsm.json
    /// and pictures
    #[command(after_help = "Example: adumbra-lab bench hrsm --scenes scenes -o docs/bench")]
    Hrsm(BenchHrsm),
    /// Every ambient-occlusion estimator compared with rays, on eight scenes; writes ao.md, ao.json, a plot
    /// and pictures
    #[command(after_help = "Example: adumbra-lab bench ao --scenes scenes --truth truth -o docs/bench")]
    Ao(BenchAo),
    /// A flight through a streamed file: what the first picture takes, which pixels are coarser than wanted,
    /// and what is wrong at rest; writes stream-SCENE.md, stream-SCENE.json and a plot
    #[command(
        after_help = "Example: adumbra-lab bench stream --scene city.glb --file city.adumbra -o docs/bench"
    )]
    Stream(BenchStream),
}

/// The measurements of `bench bake`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SuiteArg {
    /// Time, memory and file size by scene, resolution and option
    Tables,
    /// The requirements on the fast bake
    Fast,
}

/// The folder that the benchmarks of bakes load scenes from.
#[derive(clap::Args)]
pub(crate) struct SceneFolder {
    /// Folder of scenes
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: PathBuf,
    /// Read files outside the folder too, where those scenes name them; for scenes that you trust
    #[arg(long)]
    pub(crate) allow_outside: bool,
}

/// Options of the benchmarks that compare shadows with truth files.
#[derive(clap::Args)]
pub(crate) struct TruthBench {
    /// Folder of scenes
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: PathBuf,
    /// Folder of truth files, which provide the cameras and suns, each named NAME.npz after its scene
    #[arg(long, value_name = "DIR")]
    pub(crate) truth: PathBuf,
    #[command(flatten)]
    pub(crate) resolutions: ResolutionArgs,
    #[command(flatten)]
    pub(crate) cube: CubeArgs,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
    /// Folder for the tables
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

/// Options of the benchmarks that leave pictures of their frames.
#[derive(clap::Args)]
pub(crate) struct PictureBench {
    /// Frames that each median time is taken over
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = frames)]
    pub(crate) frames: u32,
    /// Size of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub(crate) size: [u32; 2],
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
    #[command(flatten)]
    pub(crate) cache: CacheArgs,
    /// Folder for tables, plots and pictures
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

/// Options of `bench bake`.
#[derive(clap::Args)]
pub struct BenchBake {
    /// What to measure
    #[arg(long, value_enum, default_value = "tables")]
    pub(crate) suite: SuiteArg,
    #[command(flatten)]
    pub(crate) folder: SceneFolder,
    /// Scene files in that folder
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "kaykit_city_21.glb,zdm2.glb,alpine-2.glb,delft.glb,box-city-5k.glb,dragon_202k.ply"
    )]
    pub(crate) names: Vec<String>,
    /// Resolutions of the bakes
    #[arg(long, value_delimiter = ',', default_value = "1024,2048,4096,8192,16384")]
    pub(crate) resolutions: Vec<u64>,
    /// Resolution of the table that varies the options
    #[arg(long, default_value_t = 8192)]
    pub(crate) variant_resolution: u64,
    /// --suite fast: only rows whose name, such as box-city-51k-65536 or query, contains one of these
    #[arg(long, value_name = "TEXT", value_delimiter = ',', num_args = 1..)]
    pub(crate) only: Vec<String>,
    /// --suite fast: skip rows of a higher resolution
    #[arg(long, value_name = "N")]
    pub(crate) max_n: Option<u64>,
    /// --suite fast: points per row that are compared with rays
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    pub(crate) samples: u64,
    /// Folder for the tables
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

/// Options of `bench verify`.
#[derive(clap::Args)]
pub struct BenchVerify {
    #[command(flatten)]
    pub(crate) folder: SceneFolder,
    /// Scene files in that folder
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "zdm2.glb,kaykit_city_21.glb,dragon_202k.ply,armadillo.ply,alpine-2.glb,street-1.glb,delft.glb,bridge_garden.glb,auster.obj,box-city-5k.glb,oak_medium.glb"
    )]
    pub(crate) names: Vec<String>,
    /// Resolution of the bakes
    #[arg(long, default_value_t = 8192)]
    pub(crate) resolution: u64,
    /// Points per scene and sun
    #[arg(long, default_value_t = 1_000_000)]
    pub(crate) samples: u64,
    /// Filter widths; each gets its own row
    #[arg(long, value_name = "K,...", value_delimiter = ',', default_value = "1")]
    pub(crate) filter: Vec<u32>,
    /// Sample points in free space instead of points on surfaces, on files that keep shadows below the last
    /// surface
    #[arg(long)]
    pub(crate) volume: bool,
    /// Folder for the tables
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

/// Options of `bench tree`.
#[derive(clap::Args)]
pub struct BenchTree {
    #[command(flatten)]
    pub(crate) folder: SceneFolder,
    /// Scene files in that folder; primitives and landscape are generated
    #[arg(long, value_delimiter = ',', default_value = "primitives,landscape,zdm2.glb,kaykit_city_21.glb")]
    pub(crate) names: Vec<String>,
    /// Tree depths in the tables of the builders
    #[arg(long, value_delimiter = ',', default_value = "8,9,10,11,12",
        value_parser = clap::value_parser!(u32).range(3..=14))]
    pub(crate) depths: Vec<u32>,
    /// Runs that each median is taken over
    #[arg(long, default_value_t = 9, value_parser = runs)]
    pub(crate) runs: usize,
    /// Points that are compared with rays
    #[arg(long, default_value_t = 200_000)]
    pub(crate) samples: u64,
    /// Measure only these sections, and keep the others of an earlier tree.json
    #[arg(long, value_delimiter = ',', value_parser = ["builders", "reductions", "frames", "options", "filters"])]
    pub(crate) only: Vec<String>,
    /// Folder for tables, plots and pictures
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

/// Options of `bench blur`.
#[derive(clap::Args)]
pub struct BenchBlur {
    /// Numbers of samples along a line
    #[arg(long, value_delimiter = ',', default_value = "8,16,24,32,48,64",
        value_parser = clap::value_parser!(u32).range(8..=64))]
    pub(crate) samples: Vec<u32>,
    /// Runs that each median is taken over
    #[arg(long, default_value_t = 5, value_parser = runs)]
    pub(crate) runs: usize,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = parse_size)]
    pub(crate) size: [u32; 2],
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
    /// Folder for tables and the plot
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Print the results as one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

fn runs(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| (1..=99).contains(n)).ok_or_else(|| "give a number from 1 to 99".to_owned())
}

/// Options of `bench shadows`.
#[derive(clap::Args)]
pub struct BenchShadows {
    #[command(flatten)]
    pub(crate) common: TruthBench,
    /// Scenes, without file extensions
    #[arg(long, value_delimiter = ',', default_value = "zdm2,kaykit_city_21,alpine-2,auster")]
    pub(crate) names: Vec<String>,
    /// Techniques to compare, written as for render
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "voxel:filter=1,csm:filter=1,voxel:filter=5,csm:filter=5,voxel:filter=9,voxel-cubes,sm,pcf,pcss,vsm,evsm,msm,csm-vsm,csm-evsm,blur,blur-bilateral"
    )]
    pub(crate) shadow: Vec<String>,
    /// Scene used to compare costs
    #[arg(long, value_name = "NAME", default_value = "kaykit_city_121")]
    pub(crate) cost_scene: String,
    /// Techniques whose costs are compared on that scene
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "voxel:filter=9,csm:filter=5,csm:filter=5:static=cached"
    )]
    pub(crate) cost_shadow: Vec<String>,
    /// Frames that each median time is taken over
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub(crate) frames: u32,
    /// Frames of the camera path along which shimmer is measured
    #[arg(long, value_name = "N", default_value_t = 12)]
    pub(crate) path_frames: u32,
    /// Size of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub(crate) size: [u32; 2],
    #[command(flatten)]
    pub(crate) cache: CacheArgs,
}

/// Options of `bench lookup`.
#[derive(clap::Args)]
pub struct BenchLookup {
    #[command(flatten)]
    pub(crate) common: TruthBench,
    /// Scenes, without file extensions
    #[arg(long, value_delimiter = ',', default_value = "zdm2,kaykit_city_21,alpine-2,auster")]
    pub(crate) names: Vec<String>,
    /// Filter widths
    #[arg(long, value_name = "K,...", value_delimiter = ',', default_value = "1,3,5,9,17")]
    pub(crate) filter: Vec<u32>,
    /// Size of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = parse_size)]
    pub(crate) size: [u32; 2],
    /// Frames per technique and view, of whose milliseconds the median counts
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) frames: u32,
    /// One group of 8 × 4 pixels of this many is counted
    #[arg(long, value_name = "N", default_value_t = 61, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) every: u32,
}

/// Options of `bench gpu`.
#[derive(clap::Args)]
pub struct BenchGpu {
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
    /// Size of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = parse_size)]
    pub(crate) size: [u32; 2],
    /// Most frames that a median is taken over
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) frames: u32,
    /// Seconds after which nothing more is begun
    #[arg(long, value_name = "S", default_value_t = 450, value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) seconds: u64,
    /// Resolution of files, except where it is varied: texels on the longest side
    #[arg(long, value_name = "N", default_value_t = 16384)]
    pub(crate) resolution: u64,
    /// Resolutions that are compared
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_value = "8192,16384,32768,65536")]
    pub(crate) resolutions: Vec<u64>,
    /// Copies of the city along each side of the large one; 10 make 15 million triangles
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=32))]
    pub(crate) tiles: u32,
    /// Folder for the tables
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

/// Options of `bench peers`.
#[derive(clap::Args)]
pub struct BenchPeers {
    #[command(flatten)]
    pub(crate) common: TruthBench,
    /// A technique, written as for render; may be repeated [default: every technique, plus several
    /// voxel filters and finer cascades]
    #[arg(long, value_name = "NAME[:KEY=VALUE...]")]
    pub(crate) shadow: Vec<String>,
}

/// Options of `bench hrsm`.
#[derive(clap::Args)]
pub struct BenchHrsm {
    /// Folder of scenes; dragon_202k, bunny_69k and oak_medium are taken from it
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: PathBuf,
    /// Initial resolutions of the maps
    #[arg(long, value_delimiter = ',', default_value = "1024,2048,4096", value_parser = start)]
    pub(crate) starts: Vec<u32>,
    /// Measure only these models; wires is only drawn, for a figure
    #[arg(long, value_delimiter = ',', num_args = 1..,
        value_parser = ["dragon", "bunny", "ball", "spheres", "oak", "wires"])]
    pub(crate) only: Vec<String>,
    #[command(flatten)]
    pub(crate) common: PictureBench,
}

/// Options of `bench ao`.
#[derive(clap::Args)]
#[command(mut_arg("size", |size| {
    size.help("Size of the still pictures in pixels; those of the camera path have half the width and height")
}))]
pub struct BenchAo {
    /// Folder of scenes: dragon_202k, bunny_69k, armadillo, dream_apartment, zdm2, kaykit_city_21,
    /// bridge_garden, box-city-5k
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: PathBuf,
    /// Folder of truth files, for the comparison with current engines [default: skip that table]
    #[arg(long, value_name = "DIR")]
    pub(crate) truth: Option<PathBuf>,
    /// Measure only these scenes
    #[arg(long, value_delimiter = ',', num_args = 1.., value_parser = ["dragon", "bunny", "armadillo",
        "dream_apartment", "zdm2", "kaykit_city_21", "bridge_garden", "cornell"])]
    pub(crate) only: Vec<String>,
    /// Rays per pixel of the truth
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub(crate) rays: u32,
    #[command(flatten)]
    pub(crate) common: PictureBench,
}

fn start(text: &str) -> Result<u32, String> {
    let known = |n: &u32| [1024, 2048, 4096, 8192].contains(n);
    text.parse().ok().filter(known).ok_or_else(|| "give 1024, 2048, 4096 or 8192".to_owned())
}

fn frames(text: &str) -> Result<u32, String> {
    text.parse().ok().filter(|n| (1..=99).contains(n)).ok_or_else(|| "give a number from 1 to 99".to_owned())
}

/// Options of `bench stream`.
#[derive(clap::Args)]
pub struct BenchStream {
    /// The scene
    #[arg(long, value_name = "SCENE")]
    pub(crate) scene: PathBuf,
    /// Its shadow file, with several levels
    #[arg(long, value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Size of the pool in MiB
    #[arg(long, value_name = "MIB", default_value_t = 32, value_parser = clap::value_parser!(u64).range(1..=8192))]
    pub(crate) budget: u64,
    /// KiB that a frame may upload
    #[arg(long, value_name = "KIB", default_value_t = 1024)]
    pub(crate) upload: usize,
    /// Milliseconds before a request is answered
    #[arg(long, value_name = "MS", default_value_t = 50)]
    pub(crate) latency: u64,
    /// Frames of the flight, at 60 per second
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub(crate) frames: u32,
    /// World units per second
    #[arg(long, value_name = "N", default_value_t = 20.0)]
    pub(crate) speed: f64,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = parse_size)]
    pub(crate) size: [u32; 2],
    /// Folder for the tables
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}
