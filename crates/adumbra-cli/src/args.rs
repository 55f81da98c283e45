//! Arguments of all verbs, each with defaults and an example.

mod bake;
#[cfg(all(test, feature = "view"))]
mod defaults;
mod farm;
mod path;
mod shard;
mod sunlight;
#[cfg(feature = "view")]
mod view;

use std::path::{Path, PathBuf};

use adumbra::ShadowFile;

#[cfg(feature = "render")]
use adumbra_compare::verbs::{compare::Compare, render, render::Render};
use adumbra_program::args::{RunArgs, SceneArgs, parse_bytes};
use adumbra_program::exit::Failure;
use adumbra_program::moment::TimeArg;
use adumbra_program::query::Query;
use adumbra_program::schemas::SchemaArgs;
use adumbra_program::verify::Verify;
use adumbra_scene::GeneratedKind;
pub(crate) use bake::{Bake, EncodingArg};
use clap::builder::PossibleValue;
use clap::{Parser, Subcommand, ValueEnum};
pub(crate) use farm::{ExportFormat, Link, Plan, Tile};
pub(crate) use path::VerifyPathArgs;
pub(crate) use shard::Shard;
pub(crate) use sunlight::{PointArgs, Sky, SkyPatches, SunHours};
#[cfg(feature = "view")]
pub(crate) use view::View;

/// Bakes a sun's shadows for a whole world into a small file, and verifies the file's answers against rays.
///
/// To begin: adumbra generate city -o city.glb; adumbra bake city.glb -o city.adumbra; adumbra verify
/// city.adumbra --scene city.glb
#[derive(Parser)]
#[command(
    name = "adumbra",
    version = env!("ADUMBRA_VERSION"),
    max_term_width = 110,
    after_help = "Exit codes: 0 success, 1 a check failed, 2 wrong usage, 3 bad input, 4 out of memory or disk, 5 GPU device lost, 75 try again later, 130 interrupted."
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) verb: Verb,
    /// End once the arguments are parsed. This is how documents are checked whose commands take hours
    #[arg(long, global = true, hide = true)]
    pub(crate) check_arguments: bool,
}

#[derive(Subcommand)]
pub(crate) enum Verb {
    /// Write a scene generated from a seed: same seed, same bytes
    #[command(after_help = "Example: adumbra generate city --seed 7 -o city.glb")]
    Generate(Generate),
    /// Print what a scene contains and which resolution suits it
    #[command(after_help = "Example: adumbra inspect city.glb --json")]
    Inspect(Inspect),
    /// Bake a scene's sun shadows into a file
    #[command(
        after_help = "Example: adumbra bake city.glb --sun 0.5,0.8,0.35 --resolution 16384 -o city.adumbra",
        after_long_help = "Example: adumbra bake city.glb --sun 0.5,0.8,0.35 --resolution 16384 -o city.adumbra\n\n\
        Presets: draft 2048, low 4096, medium 8192, high 16384, ultra 32768 texels on the longest side; \
        --resolution and --voxel-size override --preset."
    )]
    Bake(Box<Bake>),
    /// Print what a shadow file contains
    #[command(after_help = "Example: adumbra info city.adumbra --json")]
    Info(Info),
    /// Compare a shadow file's answers with rays at random points; exit code 1 if a promise is missed, such
    /// as --min-interior
    #[command(after_help = "Example: adumbra verify city.adumbra --scene city.glb --samples 1000000")]
    Verify(VerifyFile),
    /// Look up the visibility of points in a shadow file
    #[command(
        after_help = "Points and normals are little-endian float32 triples (float64 for points given by --points-f64). Each \
        answer is one float32: 1 lit, 0 shadowed.\n\n\
        Example: adumbra query city.adumbra --points p.f32 --normals n.f32 --filter 9 -o v.f32"
    )]
    Query(QueryFile),
    /// Inspect or prune a bake cache
    #[command(subcommand)]
    Cache(Cache),
    /// Write what a bake consists of, so that many machines can share it
    #[command(
        after_help = "Then tile bakes the parts, on any machines and in any order, and link makes the file.\n\n\
        Example: adumbra plan city.glb --resolution 65536 --export make --shards 16"
    )]
    Plan(Box<Plan>),
    /// Bake parts of a plan; what is there already is left as it is
    #[command(after_help = "Example: adumbra tile --plan city.plan.json --shard 0/16")]
    Tile(Tile),
    /// Make the shadow file of a plan whose parts are baked; exit code 75 if some are missing
    #[command(after_help = "Example: adumbra link --plan city.plan.json -o city.adumbra")]
    Link(Link),
    /// Convert a shadow file to another encoding
    #[command(after_help = "Example: adumbra convert city.adumbra --encoding raw -o city.raw.adumbra")]
    Convert(Convert),
    /// Tell how long points see the sun on a day, to the minute, by rays
    #[command(
        after_help = "North is -Z and east +X. Each step of the day counts as lit if its first sun is.\n\n\
        Example: adumbra sun-hours city.glb --grid 0.5 --lat 48.14 --lon 11.58 --tz Europe/Berlin --date 2026-06-21 --from 7 --to 19 -o hours.png -o hours.csv"
    )]
    SunHours(Box<SunHours>),
    /// Tell which patches of the sky points see, and how much of its light arrives
    #[command(
        after_help = "Patches go from the horizon up, and in each row clockwise from north, as in Radiance.\n\n\
        Example: adumbra sky city.glb --grid 2 --patches 577 -o sky.csv"
    )]
    Sky(Box<Sky>),
    #[cfg(feature = "render")]
    /// Draw a scene with a file's shadows, with a real-time technique or with rays, or mark where file and
    /// rays differ
    #[command(after_help = render::after_help("adumbra", adumbra_render::Techniques::product()))]
    Render(Render),
    #[cfg(feature = "view")]
    /// Open a window on a scene: every technique, side by side, while shadows are baked in the background; ?
    /// shows the keys
    #[command(after_help = view::AFTER_HELP)]
    View(View),
    #[cfg(feature = "render")]
    /// Compare techniques with ray-traced truth: milliseconds, bytes and errors as tables, and pictures
    #[command(
        after_help = "Writes report.md, report.json, sheet.png, and per technique a picture and a difference picture (red = lit called shadowed, \
        blue = shadowed called lit); with --path also path.csv and path.svg.\n\n\
        Example: adumbra compare city.glb --camera street --shadow csm:cascades=4 --shadow voxel:filter=9 -o compared"
    )]
    Compare(Compare),
    /// Run the whole workflow on a generated scene; leaves the file, pictures and a report
    #[command(after_help = "Example: adumbra demo --out demo")]
    Demo(Demo),
    /// Print the JSON Schema of what a verb prints with --json; without a verb, list those that have one
    #[command(after_help = "Example: adumbra schema bake")]
    Schema(SchemaArgs),
}

/// The kind of scene to generate.
#[derive(Clone, Copy)]
pub(crate) struct KindArg(pub(crate) GeneratedKind);

impl ValueEnum for KindArg {
    fn value_variants<'a>() -> &'a [Self] {
        &[
            Self(GeneratedKind::Spheres),
            Self(GeneratedKind::Primitives),
            Self(GeneratedKind::Landscape),
            Self(GeneratedKind::City),
            Self(GeneratedKind::Ball),
            Self(GeneratedKind::SphereGrid),
            Self(GeneratedKind::Wires),
            Self(GeneratedKind::Cornell),
            Self(GeneratedKind::Forest),
            Self(GeneratedKind::Pylons),
        ]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let (name, help) = match self.0 {
            GeneratedKind::Spheres => ("spheres", "A field of spheres over a ground square"),
            GeneratedKind::Primitives => ("primitives", "A few simple solids"),
            GeneratedKind::Landscape => ("landscape", "Low-poly terrain with trees, rocks and houses"),
            GeneratedKind::City => ("city", "Closed boxes along streets"),
            GeneratedKind::Ball => ("ball", "A ball with dimples, 268,800 triangles, without ground"),
            GeneratedKind::SphereGrid => {
                ("sphere-grid", "25 spheres in the air and on the ground, 12,000 triangles, without ground")
            }
            GeneratedKind::Wires => {
                ("wires", "A pavilion of thin rods with railings, braces and a net, without ground")
            }
            GeneratedKind::Cornell => {
                ("cornell", "A room that is open on one side, with coloured walls and two blocks")
            }
            GeneratedKind::Forest => {
                ("forest", "1,000 trees with a million cards of leaves, cut out by alpha")
            }
            GeneratedKind::Pylons => {
                ("pylons", "2 km of a power line along a road, with lamp posts and a fence")
            }
        };
        Some(PossibleValue::new(name).help(help))
    }
}

#[derive(clap::Args)]
pub(crate) struct Generate {
    /// What to generate
    pub(crate) kind: KindArg,
    /// Seed of the scene
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// The GLB file to write
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(clap::Args)]
pub(crate) struct Inspect {
    /// Scene: .glb, .gltf, .obj or .ply
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) load: SceneArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(clap::Args)]
pub(crate) struct Info {
    /// Shadow file
    pub(crate) file: PathBuf,
    /// Draw the bytes of each page of a level, not coded: from the fewest, dark blue, over green to the most,
    /// yellow, on a logarithmic scale; pages without bytes are grey
    #[arg(long, value_name = "PNG")]
    pub(crate) picture: Option<PathBuf>,
    /// Level of detail of the picture, 0 = the finest
    #[arg(long, value_name = "N", default_value_t = 0, requires = "picture")]
    pub(crate) level: u32,
    /// Print the lines that an app needs to use the file, and nothing else
    #[arg(long, value_enum, value_name = "ENGINE", conflicts_with_all = ["picture", "json"])]
    pub(crate) snippet: Option<SnippetArg>,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// What a snippet is for.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum SnippetArg {
    /// A web page with three.js
    Three,
}

/// A level of detail of a shadow file.
#[derive(clap::Args)]
pub(crate) struct LevelArg {
    /// Level of detail, 0 = the finest
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) level: u32,
}

impl LevelArg {
    /// Returns the level of a file that was read from `path`.
    pub(crate) fn of(&self, file: &ShadowFile, path: &Path) -> Result<ShadowFile, Failure> {
        file.level(self.level).ok_or_else(|| {
            let last = file.level_count() - 1;
            Failure::Usage(format!(
                "--level {}: the levels of {} are 0 to {last}",
                self.level,
                path.display()
            ))
        })
    }
}

#[derive(clap::Args)]
pub(crate) struct VerifyFile {
    #[command(flatten)]
    pub(crate) verify: Verify,
    #[command(flatten)]
    pub(crate) level: LevelArg,
    #[command(flatten)]
    pub(crate) path: VerifyPathArgs,
}

#[derive(clap::Args)]
pub(crate) struct QueryFile {
    #[command(flatten)]
    pub(crate) query: Query,
    #[command(flatten)]
    pub(crate) level: LevelArg,
    /// The moment to look up in a sun path: by its local clock, such as 12:30, or its seconds
    #[arg(long, value_name = "TIME")]
    pub(crate) time: Option<TimeArg>,
}

#[derive(clap::Args)]
pub(crate) struct Convert {
    /// Shadow file
    pub(crate) file: PathBuf,
    /// How the new file is stored
    #[arg(long, value_enum)]
    pub(crate) encoding: EncodingArg,
    /// The shadow file to write [default: the file itself]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(Subcommand)]
pub(crate) enum Cache {
    /// Count what is there
    #[command(after_help = "Example: adumbra cache info city.cache")]
    Info(CacheInfo),
    /// Remove what was used longest ago
    #[command(after_help = "Example: adumbra cache prune city.cache --keep 2GiB")]
    Prune(CachePrune),
}

#[derive(clap::Args)]
pub(crate) struct CacheInfo {
    /// Folder or URL of a bake cache
    pub(crate) place: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(clap::Args)]
pub(crate) struct CachePrune {
    /// Folder or URL of a bake cache
    pub(crate) place: PathBuf,
    /// What may stay, such as 500MB or 2GiB
    #[arg(long, value_name = "SIZE", value_parser = parse_bytes)]
    pub(crate) keep: u64,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(clap::Args)]
pub(crate) struct Demo {
    /// Folder for the scene, the file, the pictures and the report
    #[arg(long, value_name = "DIR", default_value = "demo")]
    pub(crate) out: PathBuf,
    /// Resolution of the bake: texels on the longest side
    #[arg(long, value_name = "N", default_value_t = 8192)]
    pub(crate) resolution: u64,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}
