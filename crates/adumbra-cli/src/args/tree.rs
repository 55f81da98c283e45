//! Options of world-aligned trees.

use adumbra::bake;
use adumbra::query::Weights;
use adumbra::tree::{Builder, CaptureBias, Detail, Reduction, Region, TreeOptions};
use clap::ValueEnum;

use super::{BakeSettings, WorkArgs, numbers};
use crate::exit::Failure;

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FrameArg {
    /// Columns along the light: smaller, filters like a shadow map
    Light,
    /// A cube of the world, divided into eight again and again: the paper's tree
    World,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum BuilderArg {
    /// Light frame: only blocks that silhouettes cross are drawn
    Fast,
    /// Light frame: every texel is drawn
    Plain,
    /// World frame: a function that calls itself
    Recursive,
    /// World frame: an explicit stack, one heap frame a push
    Iterative,
    /// World frame: an explicit stack of frames that are used again
    Pooled,
}

impl BuilderArg {
    fn is_light(self) -> bool {
        matches!(self, Self::Fast | Self::Plain)
    }
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum ReductionArg {
    /// Equal subtrees are found while building, by a hash of their words
    Hash,
    /// The whole tree first, then sorted from the bottom up
    Sort,
    /// As hash, by the paper's tree hash
    TreeHash,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum AttributeArg {
    /// The width of the sun's penumbra, in eighths of a voxel
    Penumbra,
}

#[derive(Clone, Copy, Default, ValueEnum)]
pub(crate) enum WeightsArg {
    /// All taps alike
    #[default]
    Mean,
    /// Less with distance: 8, 4, 1 along each axis
    Poisson,
}

impl WeightsArg {
    /// As techniques are told.
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

/// What only `--frame world` knows.
#[derive(clap::Args)]
pub(crate) struct TreeArgs {
    /// What the voxels are aligned with
    #[arg(long, value_enum, default_value = "light")]
    pub(crate) frame: FrameArg,
    /// World frame: go down to this depth (2^depth voxels across the cube) in a box in plan; may be repeated
    #[arg(long = "region", value_name = "X0,Z0,X1,Z1:DEPTH", allow_hyphen_values = true, value_parser = parse_region)]
    regions: Vec<Region>,
    /// World frame: nested squares around a point; --resolution holds in the innermost, half of it in each next one
    #[arg(long, value_name = "X,Z:R1,R2,…", allow_hyphen_values = true, value_parser = parse_rings,
        conflicts_with = "regions")]
    rings: Option<Detail>,
    /// World frame: store subtrees that mirror each other once, with pointers of variable width
    #[arg(long)]
    pub(crate) symmetry: bool,
    /// World frame: merge similar subtrees, changing at most this share of the voxels at shadow borders
    #[arg(long, value_name = "SHARE", value_parser = parse_share)]
    pub(crate) lossy: Option<f64>,
    /// World frame: keep a byte for each voxel at a shadow border
    #[arg(long, value_enum, conflicts_with = "symmetry")]
    pub(crate) attribute: Option<AttributeArg>,
    /// How the bake is made; every point that must be answered has the same answer [default: light: fast, world: pooled]
    #[arg(long, value_enum)]
    builder: Option<BuilderArg>,
    /// World frame: how equal subtrees are found; the result is the same [default: hash]
    #[arg(long, value_enum)]
    reduction: Option<ReductionArg>,
    /// World frame: test every voxel, also where the min/max pyramid decides; the result is the same
    #[arg(long)]
    exhaustive: bool,
    /// World frame: depths move away from the light by this, in texels of the depth image [default: 0]
    #[arg(long, value_name = "TEXELS")]
    capture_bias_constant: Option<f64>,
    /// World frame: and by this times the slope [default: 0.75]
    #[arg(long, value_name = "TEXELS")]
    capture_bias_slope: Option<f64>,
}

impl TreeArgs {
    /// An error where an option of the world frame stands beside the light frame, or the other way round.
    fn check(&self, settings: &BakeSettings) -> Result<(), Failure> {
        let needless = |given: &[(bool, &'static str)], frame: &str, other: &str| match given
            .iter()
            .find(|(given, _)| *given)
        {
            Some((_, option)) => Err(Failure::Usage(format!(
                "{option} means nothing with --frame {frame}; leave it out, or bake with --frame {other}"
            ))),
            None => Ok(()),
        };
        match self.frame {
            FrameArg::Light => needless(
                &[
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
                ],
                "light",
                "world",
            ),
            FrameArg::World => {
                needless(
                    &[(self.builder.is_some_and(BuilderArg::is_light), "this --builder")],
                    "world",
                    "light",
                )?;
                needless(&settings.light_only(), "world", "light")
            }
        }
    }

    /// How the columns of the light frame are found.
    pub(crate) fn light_builder(&self) -> bake::Builder {
        match self.builder {
            Some(BuilderArg::Plain) => bake::Builder::Plain,
            _ => bake::Builder::Fast,
        }
    }
}

impl BakeSettings {
    /// Whether the bake is a world-aligned tree; an error where options of both frames are mixed.
    pub(crate) fn is_tree(&self) -> Result<bool, Failure> {
        self.tree.check(self)?;
        if let (bake::Builder::Plain, Some(layout)) = (self.tree.light_builder(), self.fast_only_layout()) {
            return Err(Failure::Usage(format!(
                "--builder plain makes no --layout {layout}; leave one of them out"
            )));
        }
        Ok(self.tree.frame == FrameArg::World)
    }

    /// Options of a world-aligned bake.
    pub(crate) fn tree_options(&self, ignore_alpha: bool, work: &WorkArgs) -> Result<TreeOptions, Failure> {
        let common = self.options(ignore_alpha, work)?;
        let tree = &self.tree;
        let default = TreeOptions::new(common.sun, common.size);
        let bias = default.capture_bias;
        Ok(TreeOptions {
            detail: match &tree.rings {
                Some(rings) => rings.clone(),
                None if tree.regions.is_empty() => Detail::Uniform,
                None => Detail::Regions(tree.regions.clone()),
            },
            closed_regions: common.closed_regions,
            ignore_alpha,
            bounds: common.bounds,
            builder: match tree.builder {
                Some(BuilderArg::Recursive) => Builder::Recursive,
                Some(BuilderArg::Iterative) => Builder::Iterative,
                Some(BuilderArg::Pooled) => Builder::Pooled,
                Some(BuilderArg::Fast | BuilderArg::Plain) | None => default.builder,
            },
            reduction: match tree.reduction {
                Some(ReductionArg::Hash) => Reduction::Hash,
                Some(ReductionArg::Sort) => Reduction::Sort,
                Some(ReductionArg::TreeHash) => Reduction::TreeHash,
                None => default.reduction,
            },
            prune: !tree.exhaustive,
            capture_bias: CaptureBias {
                constant_texels: tree.capture_bias_constant.unwrap_or(bias.constant_texels),
                slope_texels: tree.capture_bias_slope.unwrap_or(bias.slope_texels),
            },
            max_memory_bytes: common.max_memory_bytes,
            ..default
        })
    }
}

fn parse_region(text: &str) -> Result<Region, String> {
    let (corners, depth) = text.split_once(':').ok_or("give X0,Z0,X1,Z1:DEPTH")?;
    let [x0, z0, x1, z1] = numbers::<4>(corners)?;
    let depth = depth.trim().parse().map_err(|_| format!("{depth:?} is not a depth, such as 11"))?;
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
    let share =
        number.trim().parse::<f64>().map_err(|_| format!("{text:?} is not a share, such as 0.5%"))? * scale;
    if (0.0..=1.0).contains(&share) { Ok(share) } else { Err(format!("{text} is not between 0 and 100 %")) }
}
