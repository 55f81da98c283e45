//! Options of world-aligned trees.

use adumbra_bake::{self as bake, BakeOptions, FrameChoice};
use adumbra_program::args::numbers;
use adumbra_program::exit::Failure;
use adumbra_tree::query::Weights;
use adumbra_tree::{Builder, CaptureBias, Detail, Reduction, Region, TreeOptions};
use clap::ValueEnum;

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FrameArg {
    /// Oblique or light, whichever file a forecast says is smaller; light below 5° of sun
    Auto,
    /// Columns along the light, in a plane across it
    Light,
    /// Columns along the light, over level ground: small where roofs are flat and walls are parallel
    Oblique,
    /// A cube of the world, divided into eight recursively: the paper's tree
    World,
}

impl FrameArg {
    pub(crate) fn is_world(self) -> bool {
        self == Self::World
    }
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum BuilderArg {
    /// Columns: draw only blocks that silhouettes cross
    Fast,
    /// Columns: draw every texel
    Plain,
    /// World frame: a recursive function
    Recursive,
    /// World frame: an explicit stack, one heap frame per push
    Iterative,
    /// World frame: an explicit stack of frames that are reused
    Pooled,
}

impl BuilderArg {
    fn is_light(self) -> bool {
        matches!(self, Self::Fast | Self::Plain)
    }
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

impl WeightsArg {
    /// Returns the name that techniques use.
    #[cfg(feature = "render")]
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::Poisson => "poisson",
        }
    }
}

impl From<WeightsArg> for Weights {
    fn from(weights: WeightsArg) -> Self {
        match weights {
            WeightsArg::Mean => Self::Mean,
            WeightsArg::Poisson => Self::Poisson,
        }
    }
}

/// Help heading of options that change how a bake is made but none of its answers.
const REPRODUCE: &str = "Only to reproduce the papers' tables";

/// The choice of the frame, and the options of `--frame world`.
#[derive(clap::Args)]
pub(crate) struct TreeArgs {
    /// How the voxels lie in the world
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) frame: FrameArg,
    /// Oblique frame: turn of the grid [default: along most of the scene's edges]
    ///
    /// The angle from +X to the grid's x axis, towards +Z.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    yaw: Option<f64>,
    /// World frame: depth of the tree (2^depth voxels across the cube) within a rectangle seen from above; may be
    /// repeated
    #[arg(hide_short_help = true, long = "region", value_name = "X0,Z0,X1,Z1:DEPTH", allow_hyphen_values = true,
        value_parser = parse_region)]
    regions: Vec<Region>,
    /// World frame: nested squares around a point; --resolution applies in the innermost, half of it in each next one
    #[arg(hide_short_help = true, long, value_name = "X,Z:R1,R2,…", allow_hyphen_values = true,
        value_parser = parse_rings, conflicts_with = "regions")]
    rings: Option<Detail>,
    /// World frame: store subtrees that mirror each other once, with pointers of variable width
    #[arg(hide_short_help = true, long)]
    pub(crate) symmetry: bool,
    /// World frame: merge similar subtrees, changing at most this share of the voxels at shadow borders
    #[arg(hide_short_help = true, long, value_name = "SHARE", value_parser = parse_share)]
    pub(crate) lossy: Option<f64>,
    /// World frame: store a byte for each voxel at a shadow border
    #[arg(hide_short_help = true, long, value_enum, conflicts_with = "symmetry")]
    pub(crate) attribute: Option<AttributeArg>,
    /// How the bake is made; every point that must be answered gets the same answer [default: columns: fast,
    /// world: pooled]
    #[arg(hide_short_help = true, long, value_enum, help_heading = REPRODUCE)]
    builder: Option<BuilderArg>,
    /// World frame: how equal subtrees are found; the result is the same [default: hash]
    #[arg(hide_short_help = true, long, value_enum, help_heading = REPRODUCE)]
    reduction: Option<ReductionArg>,
    /// World frame: test every voxel, even if the min/max pyramid decides; the result is the same
    #[arg(hide_short_help = true, long, help_heading = REPRODUCE)]
    exhaustive: bool,
    /// World frame: move depths away from the light by this, in texels of the depth image [default: 0]
    #[arg(hide_short_help = true, long, value_name = "TEXELS")]
    capture_bias_constant: Option<f64>,
    /// World frame: also move them by this per unit of slope, in texels of the depth image [default: 0.75]
    #[arg(hide_short_help = true, long, value_name = "TEXELS")]
    capture_bias_slope: Option<f64>,
}

impl TreeArgs {
    /// Checks that no option of one kind of file is given with the other. `columns_only` lists options of files of
    /// columns outside this group, and whether each was given.
    pub(super) fn check(&self, columns_only: &[(bool, &'static str)]) -> Result<(), Failure> {
        let frame = self.frame.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned());
        let needless =
            |given: &[(bool, &'static str)], other: &str| match given.iter().find(|(given, _)| *given) {
                Some((_, option)) => Err(Failure::Usage(format!(
                    "{option} does not apply to --frame {frame}; remove it, or bake with --frame {other}"
                ))),
                None => Ok(()),
            };
        if self.frame != FrameArg::Oblique {
            needless(&[(self.yaw.is_some(), "--yaw")], "oblique")?;
        }
        if self.frame.is_world() {
            needless(&[(self.builder.is_some_and(BuilderArg::is_light), "this --builder")], "light")?;
            return needless(columns_only, "light");
        }
        let world_only = [
            (!self.regions.is_empty(), "--region"),
            (self.rings.is_some(), "--rings"),
            (self.symmetry, "--symmetry"),
            (self.lossy.is_some(), "--lossy"),
            (self.attribute.is_some(), "--attribute"),
            (self.exhaustive, "--exhaustive"),
            (self.builder.is_some_and(|b| !b.is_light()), "this --builder"),
            (self.reduction.is_some(), "--reduction"),
            (self.capture_bias_constant.is_some(), "--capture-bias-constant"),
            (self.capture_bias_slope.is_some(), "--capture-bias-slope"),
        ];
        needless(&world_only, "world")
    }

    /// Returns the frame of a file of columns. A tree does not use it.
    pub(super) fn columns_frame(&self) -> FrameChoice {
        match (self.frame, self.yaw) {
            (FrameArg::Auto, _) => FrameChoice::Auto,
            (FrameArg::Light | FrameArg::World, _) => FrameChoice::Light,
            (FrameArg::Oblique, None) => FrameChoice::Oblique,
            (FrameArg::Oblique, Some(degrees)) => FrameChoice::ObliqueAt(degrees.to_radians()),
        }
    }

    /// Returns the options of a world-aligned bake. Options that both frames share come from `common`.
    pub(super) fn options(&self, common: &BakeOptions) -> TreeOptions {
        let default = TreeOptions::new(common.sun, common.size);
        let bias = default.capture_bias;
        TreeOptions {
            detail: match &self.rings {
                Some(rings) => rings.clone(),
                None if self.regions.is_empty() => Detail::Uniform,
                None => Detail::Regions(self.regions.clone()),
            },
            closed_regions: common.closed_regions,
            ignore_alpha: common.ignore_alpha,
            bounds: common.bounds,
            builder: match self.builder {
                Some(BuilderArg::Recursive) => Builder::Recursive,
                Some(BuilderArg::Iterative) => Builder::Iterative,
                Some(BuilderArg::Pooled) => Builder::Pooled,
                Some(BuilderArg::Fast | BuilderArg::Plain) | None => default.builder,
            },
            reduction: match self.reduction {
                Some(ReductionArg::Hash) => Reduction::Hash,
                Some(ReductionArg::Sort) => Reduction::Sort,
                Some(ReductionArg::TreeHash) => Reduction::TreeHash,
                None => default.reduction,
            },
            prune: !self.exhaustive,
            capture_bias: CaptureBias {
                constant_texels: self.capture_bias_constant.unwrap_or(bias.constant_texels),
                slope_texels: self.capture_bias_slope.unwrap_or(bias.slope_texels),
            },
            max_memory_bytes: common.max_memory_bytes,
            ..default
        }
    }

    /// Returns the method that finds the columns.
    pub(crate) fn light_builder(&self) -> bake::Builder {
        match self.builder {
            Some(BuilderArg::Plain) => bake::Builder::Plain,
            _ => bake::Builder::Fast,
        }
    }
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
