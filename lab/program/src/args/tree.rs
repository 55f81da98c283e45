//! Arguments of `tree`: the world-aligned tree of the 2021 paper.

use std::path::PathBuf;

use adumbra::{Bounds, Sun};
use adumbra_bake::Size;
use adumbra_papers::tree::query::Weights;
use adumbra_papers::tree::texture::{MAX_SIDE, MIN_SIDE};
use adumbra_papers::tree::{CaptureBias, Detail, Reduction, Region, TreeBuilder, TreeOptions};
use adumbra_program::args::{RunArgs, SceneArgs, SunArgs, numbers, parse_bounds};
use adumbra_program::progress::Style;
use adumbra_program::query::Query;
use adumbra_program::verify::Verify;
use clap::{Subcommand, ValueEnum};

/// What `adumbra-lab tree` does.
#[derive(Subcommand)]
pub enum TreeVerb {
    /// Bake a scene's sun shadows into a tree
    #[command(
        after_help = "Example: adumbra-lab tree bake city.glb --resolution 2048 --rings 0,0:40,120 -o city.adumtree"
    )]
    Bake(Box<TreeBake>),
    /// Print what a tree file contains
    #[command(after_help = "Example: adumbra-lab tree info city.adumtree --json")]
    Info(TreeInfo),
    /// Compare a tree file's answers with rays at random points; exit code 1 if a promise is missed
    #[command(
        after_help = "Example: adumbra-lab tree verify city.adumtree --scene city.glb --samples 1000000"
    )]
    Verify(TreeVerify),
    /// Look up the visibility of points in a tree file
    #[command(after_help = "Points, normals and answers as for adumbra query.\n\n\
        Example: adumbra-lab tree query city.adumtree --points p.f32 --normals n.f32 --filter 3 -o v.f32")]
    Query(TreeQuery),
    /// Write a tree or graph file as RGBA8 PNGs, one 32-bit word of its tree per pixel
    #[command(
        after_help = "Writes page 0 to the path, and page n next to it as NAME.n.png. The words are data, not colours: keep the PNGs unchanged, and \
        load them without colour management or premultiplied alpha.\n\n\
        Example: adumbra-lab tree export city.adumtree --texture city.png"
    )]
    Export(TreeExport),
    /// Turn exported PNGs back into the file, bit for bit
    #[command(after_help = "Example: adumbra-lab tree import city.png -o city.adumtree")]
    Import(TreeImport),
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum BuilderArg {
    /// A recursive function
    Recursive,
    /// An explicit stack, one heap frame per push
    Iterative,
    /// An explicit stack of frames that are reused
    Pooled,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum ReductionArg {
    /// Find equal subtrees while building, by a hash of their words
    Hash,
    /// Build the whole tree first, then sort it from the bottom up
    Sort,
    /// Like hash, with the paper's tree hash
    TreeHash,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum AttributeArg {
    /// Width of the sun's penumbra, in eighths of a voxel
    Penumbra,
}

#[derive(Clone, Copy, Default, ValueEnum)]
pub(crate) enum WeightsArg {
    /// All taps equally
    #[default]
    Mean,
    /// Less with distance: 8, 4, 1 along each axis
    Poisson,
}

impl From<WeightsArg> for Weights {
    fn from(weights: WeightsArg) -> Self {
        match weights {
            WeightsArg::Mean => Self::Mean,
            WeightsArg::Poisson => Self::Poisson,
        }
    }
}

/// Arguments of `tree bake`.
#[derive(clap::Args)]
pub struct TreeBake {
    /// Scene: .glb, .gltf, .obj or .ply
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) sun: SunArgs,
    /// Voxels along the cube's side: a power of two, at most 32768
    #[arg(long, value_name = "N", default_value_t = 2048, conflicts_with = "voxel_size")]
    resolution: u64,
    /// Edge of a voxel in world units, instead of a resolution
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    voxel_size: Option<f64>,
    /// Answer points inside closed solids too
    #[arg(long)]
    no_closed_regions: bool,
    /// Cover this box instead of the scene
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1", allow_hyphen_values = true, value_parser = parse_bounds)]
    bounds: Option<Bounds>,
    /// Depth of the tree (2^depth voxels across the cube) within a rectangle seen from above; may be
    /// repeated
    #[arg(long = "region", value_name = "X0,Z0,X1,Z1:DEPTH", allow_hyphen_values = true,
        value_parser = parse_region)]
    regions: Vec<Region>,
    /// Nested squares around a point; --resolution applies in the innermost, half of it in each next one
    #[arg(long, value_name = "X,Z:R1,R2,…", allow_hyphen_values = true,
        value_parser = parse_rings, conflicts_with = "regions")]
    rings: Option<Detail>,
    /// Store subtrees that mirror each other once, with pointers of variable width
    #[arg(long)]
    pub(crate) symmetry: bool,
    /// Merge similar subtrees, changing at most this share of the voxels at shadow borders
    #[arg(long, value_name = "SHARE", value_parser = parse_share)]
    pub(crate) lossy: Option<f64>,
    /// Store a byte for each voxel at a shadow border
    #[arg(long, value_enum, conflicts_with = "symmetry")]
    pub(crate) attribute: Option<AttributeArg>,
    /// How the tree is built; the result is the same
    #[arg(long, value_enum, default_value = "pooled")]
    builder: BuilderArg,
    /// How equal subtrees are found; the result is the same
    #[arg(long, value_enum, default_value = "hash")]
    reduction: ReductionArg,
    /// Test every voxel, even if the min/max pyramid decides; the result is the same
    #[arg(long)]
    exhaustive: bool,
    /// Move depths away from the light by this, in texels of the depth image [default: 0]
    #[arg(long, value_name = "TEXELS")]
    capture_bias_constant: Option<f64>,
    /// Also move them by this per unit of slope, in texels of the depth image [default: 0.75]
    #[arg(long, value_name = "TEXELS")]
    capture_bias_slope: Option<f64>,
    #[command(flatten)]
    pub(crate) load: SceneArgs,
    /// The tree file to write [default: the scene's path with the extension .adumtree]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// How to show progress
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) progress: Style,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

impl TreeBake {
    /// Returns the options of the bake.
    pub(crate) fn options(&self, sun: Sun, max_memory_bytes: Option<u64>) -> TreeOptions {
        let size = self.voxel_size.map_or(Size::Resolution(self.resolution), Size::VoxelSize);
        let default = TreeOptions::new(sun, size);
        let bias = default.capture_bias;
        TreeOptions {
            detail: match &self.rings {
                Some(rings) => rings.clone(),
                None if self.regions.is_empty() => Detail::Uniform,
                None => Detail::Regions(self.regions.clone()),
            },
            closed_regions: !self.no_closed_regions,
            ignore_alpha: self.load.ignore_alpha,
            bounds: self.bounds,
            builder: match self.builder {
                BuilderArg::Recursive => TreeBuilder::Recursive,
                BuilderArg::Iterative => TreeBuilder::Iterative,
                BuilderArg::Pooled => TreeBuilder::Pooled,
            },
            reduction: match self.reduction {
                ReductionArg::Hash => Reduction::Hash,
                ReductionArg::Sort => Reduction::Sort,
                ReductionArg::TreeHash => Reduction::TreeHash,
            },
            prune: !self.exhaustive,
            capture_bias: CaptureBias {
                constant_texels: self.capture_bias_constant.unwrap_or(bias.constant_texels),
                slope_texels: self.capture_bias_slope.unwrap_or(bias.slope_texels),
            },
            max_memory_bytes,
            ..default
        }
    }
}

/// Arguments of `tree info`.
#[derive(clap::Args)]
pub struct TreeInfo {
    /// Tree file
    pub(crate) file: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// Arguments of `tree verify`.
#[derive(clap::Args)]
#[command(
    mut_arg("filter", |filter| filter.help("Voxels along the filter's side: 1, 3 or 5")),
    mut_arg("min_interior", |least| {
        least.help("Interior agreement below which the check fails, from 0 to 1 [default: 0.999]")
    })
)]
pub struct TreeVerify {
    #[command(flatten)]
    pub(crate) verify: Verify,
    /// How the taps are weighted
    #[arg(long, value_enum, default_value = "mean")]
    pub(crate) weights: WeightsArg,
}

/// Arguments of `tree query`.
#[derive(clap::Args)]
#[command(mut_arg("filter", |filter| filter.help("Voxels along the filter's side: 1, 3 or 5")))]
pub struct TreeQuery {
    #[command(flatten)]
    pub(crate) query: Query,
    /// How the taps are weighted
    #[arg(long, value_enum, default_value = "mean")]
    pub(crate) weights: WeightsArg,
    /// Also write the width of the sun's penumbra in world units: one little-endian float32 per point, NaN
    /// away from shadow borders; for files baked with --attribute penumbra
    #[arg(long, value_name = "FILE")]
    pub(crate) penumbra: Option<PathBuf>,
}

/// Arguments of `tree export`.
#[derive(clap::Args)]
pub struct TreeExport {
    /// Tree or graph file
    pub(crate) file: PathBuf,
    /// Path of page 0; page n is written next to it with its number before the extension
    #[arg(long, value_name = "PNG")]
    pub(crate) texture: PathBuf,
    /// Largest width and height of a page, in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = MAX_SIDE,
        value_parser = clap::value_parser!(u32).range(i64::from(MIN_SIDE)..=i64::from(MAX_SIDE)))]
    pub(crate) max_side: u32,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// Arguments of `tree import`.
#[derive(clap::Args)]
pub struct TreeImport {
    /// Page 0 of an export; the other pages are looked for next to it
    pub(crate) texture: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

fn parse_region(text: &str) -> Result<Region, String> {
    let (corners, depth) = text.split_once(':').ok_or("give X0,Z0,X1,Z1:DEPTH")?;
    let [x0, z0, x1, z1] = numbers::<4>(corners)?;
    let depth = depth
        .trim()
        .parse()
        .map_err(|_| format!("{depth:?} is not a depth; give a whole number such as 11"))?;
    Ok(Region { x: [x0, x1], z: [z0, z1], depth })
}

fn parse_rings(text: &str) -> Result<Detail, String> {
    let (center, radii) = text.split_once(':').ok_or("give X,Z:R1,R2,…")?;
    let radii: Vec<f64> = radii
        .split(',')
        .map(|r| r.trim().parse().map_err(|_| format!("{r:?} is not a number")))
        .collect::<Result<_, _>>()?;
    Ok(Detail::Rings { center_xz: numbers::<2>(center)?, radii })
}

fn parse_share(text: &str) -> Result<f64, String> {
    let (number, scale) = match text.strip_suffix('%') {
        Some(percent) => (percent, 0.01),
        None => (text, 1.0),
    };
    let share = number
        .trim()
        .parse::<f64>()
        .map_err(|_| format!("{text:?} is not a share; give one such as 0.5%"))?
        * scale;
    if (0.0..=1.0).contains(&share) { Ok(share) } else { Err(format!("{text} is not between 0 and 100 %")) }
}
