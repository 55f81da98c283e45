//! Arguments of all verbs, each with defaults and an example.

mod bake;
#[cfg(feature = "render")]
mod compare;
#[cfg(all(test, feature = "view"))]
mod defaults;
mod lookup;
mod query;
#[cfg(feature = "render")]
mod render;
mod tree;
#[cfg(feature = "view")]
mod view;

use std::path::PathBuf;

use adumbra_program::args::{RunArgs, SceneArgs};
use adumbra_scene::GeneratedKind;
use adumbra_tree::texture::{MAX_SIDE, MIN_SIDE};
pub(crate) use bake::Bake;
use clap::builder::PossibleValue;
use clap::{Parser, Subcommand, ValueEnum};
#[cfg(feature = "render")]
pub(crate) use compare::{Compare, PATH_FRAMES};
pub(crate) use lookup::{BiasArgs, LookupArgs};
pub(crate) use query::Query;
#[cfg(feature = "render")]
pub(crate) use render::{LayerArg, Render};
#[cfg(feature = "view")]
pub(crate) use view::View;

/// Bakes a sun's shadows for a whole world into a small file, and verifies the file's answers against rays.
///
/// To begin: adumbra generate city -o city.glb; adumbra bake city.glb -o city.adumbra; adumbra verify city.adumbra
/// --scene city.glb
#[derive(Parser)]
#[command(
    name = "adumbra",
    version = env!("ADUMBRA_VERSION"),
    max_term_width = 110,
    after_help = "Exit codes: 0 success, 1 a check failed, 2 wrong usage, 3 bad input, 4 out of memory or disk, 5 GPU device lost, 130 interrupted."
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
        --resolution and --voxel-size override --preset.\n\n\
        Example: adumbra bake city.glb --frame world --resolution 2048 --rings 0,0:40,120 -o city-tree.adumbra"
    )]
    Bake(Box<Bake>),
    /// Print what a shadow file contains
    #[command(after_help = "Example: adumbra info city.adumbra --json")]
    Info(Info),
    /// Compare a shadow file's answers with rays at random points; exit code 1 if a promise is missed, such as
    /// --min-interior
    #[command(after_help = "Example: adumbra verify city.adumbra --scene city.glb --samples 1000000")]
    Verify(Verify),
    /// Look up the visibility of points in a shadow file
    #[command(
        after_help = "Points and normals are little-endian float32 triples (float64 for points given by --points-f64). Each \
        answer is one float32: 1 lit, 0 shadowed.\n\n\
        Example: adumbra query city.adumbra --points p.f32 --normals n.f32 --filter 9 -o v.f32"
    )]
    Query(Query),
    /// Write a shadow file for a web page, or as RGBA8 PNGs, one 32-bit word of its tree per pixel
    #[command(
        after_help = "--web writes the file, and next to it FILE.br, which servers send in its place. --texture writes page 0 to \
        the path, and page n next to it as NAME.n.png. The words are data, not colours: keep the PNGs unchanged, and \
        load them without colour management or premultiplied alpha.\n\n\
        Example: adumbra export city.adumbra --web public/city.adumbra\n\
        Example: adumbra export city.adumbra --texture city.png"
    )]
    Export(Export),
    /// Turn exported PNGs back into the shadow file, bit for bit
    #[command(after_help = "Example: adumbra import city.png -o city.adumbra")]
    Import(Import),
    #[cfg(feature = "render")]
    /// Draw a scene with a file's shadows, with a real-time technique or with rays, or mark where file and rays differ
    #[command(after_help = render::after_help())]
    Render(Render),
    #[cfg(feature = "view")]
    /// Open a window on a scene: every technique, side by side, while shadows are baked in the background; ? shows the
    /// keys
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
    #[cfg(feature = "render")]
    /// Run the whole workflow on a generated scene; leaves the file, pictures and a report
    #[command(after_help = "Example: adumbra demo --out demo")]
    Demo(Demo),
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
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(clap::Args)]
#[command(mut_arg("filter", |filter| filter.help("Filter width, as for query")))]
pub(crate) struct Verify {
    /// Shadow file
    pub(crate) file: PathBuf,
    /// The scene that the file was baked from, loaded with the same filters
    #[arg(long)]
    pub(crate) scene: PathBuf,
    /// Number of points to compare
    #[arg(long, default_value_t = 1_000_000, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub(crate) samples: u64,
    /// Seed of the points
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Sample points in free space instead of points on surfaces; for files baked with --no-assume-ground, and for
    /// world-aligned files
    #[arg(long)]
    pub(crate) volume: bool,
    #[command(flatten)]
    pub(crate) lookup: LookupArgs,
    /// Interior agreement below which the check fails, from 0 to 1 [default: 0.999, or 0.995 for a filtered
    /// light-aligned file]
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = parse_share)]
    pub(crate) min_interior: Option<f64>,
    #[command(flatten)]
    pub(crate) load: SceneArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("to").required(true).args(["texture", "web"]))]
pub(crate) struct Export {
    /// Shadow file
    pub(crate) file: PathBuf,
    /// Path of page 0; page n is written next to it with its number before the extension
    #[arg(long, value_name = "PNG")]
    pub(crate) texture: Option<PathBuf>,
    /// Copy for a web page, compressed with Brotli next to it as FILE.br; prints the lines to paste into the page
    #[arg(long, value_name = "FILE")]
    pub(crate) web: Option<PathBuf>,
    /// Largest width and height of a page of the texture, in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = MAX_SIDE,
        value_parser = clap::value_parser!(u32).range(i64::from(MIN_SIDE)..=i64::from(MAX_SIDE)))]
    pub(crate) max_side: u32,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(clap::Args)]
pub(crate) struct Import {
    /// Page 0 of an export; the other pages are looked for next to it
    pub(crate) texture: PathBuf,
    /// The shadow file to write
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[cfg(feature = "render")]
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

fn parse_share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("give a number from 0 to 1, such as 0.999".to_owned()),
    }
}
