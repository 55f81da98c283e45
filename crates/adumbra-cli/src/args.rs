//! Arguments of every verb, with their defaults and an example each.

mod bake;
mod bench;
mod compare;
mod query;
mod render;
mod report;
mod tree;
mod view;

use std::path::{Path, PathBuf};

use adumbra::light::Sun;
use adumbra::scene::{GeneratedKind, LoadOptions, MoverPolicy, NameFilter};
use adumbra::settings::Bias;
use adumbra::texture::{MAX_SIDE, MIN_SIDE};
use adumbra_lab::truth::Cache;
pub(crate) use bake::{Bake, BakeSettings, LayoutArg};
pub(crate) use bench::{
    Bench, BenchAo, BenchBake, BenchBlur, BenchHrsm, BenchShadows, BenchTree, BenchVerb, BenchVerify,
    SuiteArg,
};
use clap::{Parser, Subcommand, ValueEnum};
pub(crate) use compare::{BenchPeers, Compare, JudgeArg};
pub(crate) use query::Query;
pub(crate) use render::{DeviceArg, DeviceArgs, LayerArg, Render};
pub(crate) use report::{Report, SECTIONS};
pub(crate) use tree::WeightsArg;
pub(crate) use view::View;

use crate::exit::Failure;

/// Bakes a sun's shadows of a whole world into a small file, and proves the answers against rays.
///
/// Begin with: adumbra generate city -o city.glb; adumbra bake city.glb -o city.adumbra; adumbra verify city.adumbra
/// --scene city.glb
#[derive(Parser)]
#[command(
    version,
    max_term_width = 110,
    after_help = "Exit codes: 0 fine, 1 a check failed, 2 usage, 3 bad input, 4 out of memory or disk, 5 GPU device lost, 130 interrupted."
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) verb: Verb,
    /// End once the arguments are parsed: how documents are checked whose commands take hours
    #[arg(long, global = true, hide = true)]
    pub(crate) check_arguments: bool,
}

#[derive(Subcommand)]
pub(crate) enum Verb {
    /// Write a scene made from a seed: same seed, same bytes
    #[command(after_help = "Example: adumbra generate city --seed 7 -o city.glb")]
    Generate(Generate),
    /// Say what a scene holds, and what resolution suits it
    #[command(after_help = "Example: adumbra inspect city.glb --json")]
    Inspect(Inspect),
    /// Bake a scene's sun shadows into a file
    #[command(
        after_help = "Example: adumbra bake city.glb --sun 0.5,0.8,0.35 --resolution 16384 -o city.adumbra\n\n\
        Presets: draft 2048, low 4096, medium 8192 (the default), high 16384, ultra 32768 texels on the longest side; \
        --resolution or --voxel-size wins over --preset. With --frame world the default is draft.\n\n\
        Example: adumbra bake city.glb --frame world --resolution 2048 --rings 0,0:40,120 -o city-tree.adumbra"
    )]
    Bake(Bake),
    /// Say what a shadow file holds
    #[command(after_help = "Example: adumbra info city.adumbra --json")]
    Info(Info),
    /// Compare a shadow file's answers with rays at random points; exit code 1 below --min-interior
    #[command(after_help = "Example: adumbra verify city.adumbra --scene city.glb --samples 1000000")]
    Verify(Verify),
    /// Answer points from a shadow file
    #[command(
        after_help = "Points and normals are little-endian float32 triples (points also float64, with --points-f64), the answers one \
        float32 each: 1 lit, 0 shadowed.\n\n\
        Example: adumbra query city.adumbra --points p.f32 --normals n.f32 --filter 9 -o v.f32"
    )]
    Query(Query),
    /// Write a shadow file as RGBA8 PNGs, one 32-bit word of its tree a pixel
    #[command(
        after_help = "Page 0 goes to the path, page n beside it as NAME.n.png. The words are data, not colours: keep the PNGs \
        unchanged, and load them without colour management or premultiplied alpha.\n\n\
        Example: adumbra export city.adumbra --texture city.png"
    )]
    Export(Export),
    /// Turn exported PNGs back into the shadow file, bit for bit
    #[command(after_help = "Example: adumbra import city.png -o city.adumbra")]
    Import(Import),
    /// Draw a scene with a file's shadows, with a real-time technique, with rays, or where file and rays differ
    #[command(after_help = render::after_help())]
    Render(Render),
    /// Open a window on a scene: every technique, side by side, while shadows are baked behind it; ? shows the keys
    #[command(after_help = view::AFTER_HELP)]
    View(View),
    /// Hold techniques beside ray-traced truth: milliseconds, bytes and errors as tables, and pictures
    #[command(
        after_help = "Writes report.md, report.json, sheet.png, and a picture and a difference picture a technique (red = lit called shadowed, \
        blue = shadowed called lit); with --path also path.csv and path.svg.\n\n\
        Example: adumbra compare city.glb --camera street --shadow csm:cascades=4 --shadow voxel:filter=9 -o compared"
    )]
    Compare(Compare),
    /// Measure: bakes, trees, shadows beside the truth, as tables
    #[command(after_help = "Example: adumbra bench bake --scenes scenes -o docs/bench")]
    Bench(Bench),
    /// Measure what every paper measured, and write one page that shows its figures beside ours; exit code 1 where a section failed
    #[command(
        after_help = "Writes report.html, which needs no other file and no network, and report.json. What is measured stays in the folder, whatever \
        happens to the rest.\n\n\
        Example: adumbra report -o report\n\nExample: adumbra report --full --scenes scenes --truth truth -o report"
    )]
    Report(Report),
    /// The main job from end to end on a generated scene; leaves the file, pictures and a report
    #[command(after_help = "Example: adumbra demo --out demo")]
    Demo(Demo),
}

/// Where the sun is.
#[derive(clap::Args)]
pub(crate) struct SunArgs {
    /// Direction towards the sun in world space, any length [default: 0.5,0.8,0.35]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = parse_triple,
        conflicts_with_all = ["azimuth", "elevation"])]
    sun: Option<[f64; 3]>,
    /// Degrees clockwise from -Z, seen from above (90 is +X)
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, requires = "elevation")]
    azimuth: Option<f64>,
    /// Degrees above the horizon
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    elevation: Option<f64>,
}

impl SunArgs {
    /// Whether any of it was given.
    pub(crate) fn is_given(&self) -> bool {
        self.sun.is_some() || self.elevation.is_some()
    }

    pub(crate) fn sun(&self) -> Result<Sun, Failure> {
        Ok(match self.elevation {
            Some(elevation) => Sun::from_angles(self.azimuth.unwrap_or(0.0), elevation)?,
            None => Sun::from_direction(self.sun.unwrap_or([0.5, 0.8, 0.35]))?,
        })
    }
}

/// What to load from a scene.
#[derive(clap::Args)]
pub(crate) struct SceneArgs {
    /// Keep only what a name pattern matches: node, mesh or material; may be repeated
    #[arg(long, value_name = "GLOB")]
    only: Vec<String>,
    /// Leave out what a name pattern matches: node, mesh or material; may be repeated
    #[arg(long, value_name = "GLOB")]
    exclude: Vec<String>,
    /// Take masked and blended materials as opaque
    #[arg(long)]
    pub(crate) ignore_alpha: bool,
    /// Take animated instances too, standing still in their first pose; without it they are left out, because they move.
    /// Give it to verify where it was given to bake
    #[arg(long)]
    include_animated: bool,
    /// Read buffers, images and material libraries outside the scene's folder too; for scenes that you trust
    #[arg(long)]
    allow_outside: bool,
}

impl SceneArgs {
    /// What was given, as words of a command.
    pub(crate) fn words(&self) -> Vec<String> {
        let named = |name: &str, list: &[String]| -> Vec<String> {
            list.iter().map(|glob| format!("{name} '{}'", glob.replace('\'', "'\\''"))).collect()
        };
        let mut words = [named("--only", &self.only), named("--exclude", &self.exclude)].concat();
        let switches = [
            (self.ignore_alpha, "--ignore-alpha"),
            (self.include_animated, "--include-animated"),
            (self.allow_outside, "--allow-outside"),
        ];
        words.extend(switches.iter().filter(|(on, _)| *on).map(|(_, name)| (*name).to_owned()));
        words
    }

    /// What to load, and how many bytes the load may hold.
    pub(crate) fn load_options(&self, max_memory_bytes: Option<u64>) -> Result<LoadOptions, Failure> {
        Ok(LoadOptions {
            filter: NameFilter::new(&self.only, &self.exclude)?,
            color_textures: false,
            ignore_alpha: self.ignore_alpha,
            movers: if self.include_animated { MoverPolicy::Freeze } else { MoverPolicy::LeaveOut },
            allow_outside: self.allow_outside,
            max_memory_bytes,
        })
    }
}

/// The look-up's bias, in texels; what is not given comes from the file.
#[derive(clap::Args)]
pub(crate) struct BiasArgs {
    /// Bias along the light, everywhere [default: the file's]
    #[arg(long, value_name = "TEXELS")]
    bias_constant: Option<f64>,
    /// Bias along the light, times the slope [default: the file's]
    #[arg(long, value_name = "TEXELS")]
    bias_slope: Option<f64>,
    /// Offset along the normal [default: the file's]
    #[arg(long, value_name = "TEXELS")]
    bias_normal: Option<f64>,
}

impl BiasArgs {
    /// What was given, as parameters of a technique.
    pub(crate) fn parameters(&self) -> String {
        let given = [("bias", self.bias_constant), ("slope", self.bias_slope), ("normal", self.bias_normal)];
        given.iter().filter_map(|(key, value)| value.map(|v| format!(":{key}={v}"))).collect()
    }

    pub(crate) fn over(&self, file: Bias) -> Result<Bias, Failure> {
        let bias = Bias {
            constant_texels: self.bias_constant.unwrap_or(file.constant_texels),
            slope_texels: self.bias_slope.unwrap_or(file.slope_texels),
            normal_offset_texels: self.bias_normal.unwrap_or(file.normal_offset_texels),
        };
        bias.check()?;
        Ok(bias)
    }
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum KindArg {
    /// A field of spheres over a ground square
    Spheres,
    /// A few simple bodies
    Primitives,
    /// Low-poly terrain with trees, rocks and houses
    Landscape,
    /// Closed boxes along streets
    City,
    /// A ball with dimples, 268,800 triangles, without a ground
    Ball,
    /// 25 spheres in the air and on the ground, 12,000 triangles, without a ground
    SphereGrid,
    /// A pavilion of thin rods with railings, braces and a net, without a ground
    Wires,
    /// A room open to one side, with coloured walls and two blocks
    Cornell,
}

impl From<KindArg> for GeneratedKind {
    fn from(kind: KindArg) -> Self {
        match kind {
            KindArg::Spheres => Self::Spheres,
            KindArg::Primitives => Self::Primitives,
            KindArg::Landscape => Self::Landscape,
            KindArg::City => Self::City,
            KindArg::Ball => Self::Ball,
            KindArg::SphereGrid => Self::SphereGrid,
            KindArg::Wires => Self::Wires,
            KindArg::Cornell => Self::Cornell,
        }
    }
}

#[derive(clap::Args)]
pub(crate) struct Generate {
    /// What to make
    pub(crate) kind: KindArg,
    /// Seed
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// The GLB file to write
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
}

#[derive(clap::Args)]
pub(crate) struct Inspect {
    /// Scene: .glb, .gltf, .obj or .ply
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) load: SceneArgs,
    /// Memory that loading may hold, such as 800MiB or 2GiB [default: 2 GiB, and 64 bytes for each byte of the scene's files]
    #[arg(long, value_name = "SIZE", value_parser = parse_bytes)]
    pub(crate) max_memory: Option<u64>,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// How much of the machine to use.
#[derive(clap::Args)]
pub(crate) struct WorkArgs {
    /// Threads; the result does not depend on it [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Memory that may be held, such as 800MiB or 2GiB; a light-aligned bake goes on with temporary files beside the output [default: no
    /// limit but for loading a scene: 2 GiB, and 64 bytes for each byte of its files]
    #[arg(long, value_name = "SIZE", value_parser = parse_bytes)]
    pub(crate) max_memory: Option<u64>,
}

impl WorkArgs {
    /// An error where `needed_bytes` are more than `--max-memory` allows.
    pub(crate) fn check_memory(&self, what: &'static str, needed_bytes: u64) -> Result<(), Failure> {
        match self.max_memory {
            Some(limit_bytes) if needed_bytes > limit_bytes => {
                Err(adumbra::Error::MemoryLimit { what, needed_bytes, limit_bytes }.into())
            }
            _ => Ok(()),
        }
    }
}

/// Where traced pictures are kept between runs.
#[derive(clap::Args)]
pub(crate) struct CacheArgs {
    /// Folder that traced pictures are kept in between runs [default: truth-cache in the output folder]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Bytes that they may take there, such as 200MiB or 4GiB; those that were used longest ago go first [default: 1GiB]
    #[arg(long, value_name = "SIZE", value_parser = parse_bytes)]
    cache_limit: Option<u64>,
}

impl CacheArgs {
    pub(crate) fn cache(&self, output: &Path) -> Cache {
        let folder = self.cache.clone().unwrap_or_else(|| output.join("truth-cache"));
        Cache::in_folder(folder, self.cache_limit.unwrap_or(Cache::DEFAULT_LIMIT_BYTES))
    }
}

#[derive(clap::Args)]
pub(crate) struct Info {
    /// Shadow file
    pub(crate) file: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(clap::Args)]
pub(crate) struct Verify {
    /// Shadow file
    pub(crate) file: PathBuf,
    /// The scene that it was baked from, loaded with the same filters
    #[arg(long)]
    pub(crate) scene: PathBuf,
    /// Points to compare
    #[arg(long, default_value_t = 1_000_000, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub(crate) samples: u64,
    /// Seed of the points
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Points in free space in place of points on surfaces; for files baked with --no-assume-ground
    #[arg(long)]
    pub(crate) volume: bool,
    /// Filter width, as for query
    #[arg(long, value_name = "K", default_value_t = 1)]
    pub(crate) filter: u32,
    /// How a world-aligned file's taps are weighted
    #[arg(long, value_enum, default_value = "mean")]
    pub(crate) weights: WeightsArg,
    /// The check fails below this interior agreement; 0.999 unless given, of a filtered light-aligned file 0.995
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = parse_share)]
    pub(crate) min_interior: Option<f64>,
    #[command(flatten)]
    pub(crate) load: SceneArgs,
    #[command(flatten)]
    pub(crate) bias: BiasArgs,
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(clap::Args)]
pub(crate) struct Export {
    /// Shadow file
    pub(crate) file: PathBuf,
    /// Where page 0 goes; page n goes beside it with its number before the ending
    #[arg(long, value_name = "PNG")]
    pub(crate) texture: PathBuf,
    /// Most pixels a side of a page
    #[arg(long, value_name = "PIXELS", default_value_t = MAX_SIDE,
        value_parser = clap::value_parser!(u32).range(i64::from(MIN_SIDE)..=i64::from(MAX_SIDE)))]
    pub(crate) max_side: u32,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(clap::Args)]
pub(crate) struct Import {
    /// Page 0 of an export; the others are looked for beside it
    pub(crate) texture: PathBuf,
    /// The shadow file to write
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(clap::Args)]
pub(crate) struct Demo {
    /// Folder for the scene, the file, the pictures and the report
    #[arg(long, value_name = "DIR", default_value = "demo")]
    pub(crate) out: PathBuf,
    /// Texels on the longest side
    #[arg(long, value_name = "N", default_value_t = 8192)]
    pub(crate) resolution: u64,
}

fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let parts: Vec<f64> = text
        .split(',')
        .map(|p| p.trim().parse::<f64>().map_err(|_| format!("{p:?} is not a number")))
        .collect::<Result<_, _>>()?;
    <[f64; N]>::try_from(parts).map_err(|p| format!("give {N} numbers with commas between, not {}", p.len()))
}

fn parse_triple(text: &str) -> Result<[f64; 3], String> {
    numbers::<3>(text)
}

fn parse_share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("give a number from 0 to 1, such as 0.999".to_owned()),
    }
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let (w, h) = text.split_once(['x', 'X']).ok_or("give WIDTHxHEIGHT, such as 1280x720")?;
    let side = |s: &str| match s.parse::<u32>() {
        Ok(n) if (1..=16384).contains(&n) => Ok(n),
        _ => Err(format!("{s:?} is not a number of pixels from 1 to 16384")),
    };
    Ok([side(w)?, side(h)?])
}

fn parse_bytes(text: &str) -> Result<u64, String> {
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let number: f64 = number.parse().map_err(|_| "give a number and a unit, such as 2GiB".to_owned())?;
    let scale = match unit.trim().to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "k" | "kib" => 1024.0,
        "kb" => 1e3,
        "m" | "mib" => 1024.0 * 1024.0,
        "mb" => 1e6,
        "g" | "gib" => 1024.0 * 1024.0 * 1024.0,
        "gb" => 1e9,
        other => return Err(format!("{other:?} is not a unit; use MiB or GiB")),
    };
    Ok((number * scale) as u64)
}
