//! Arguments of `bake`, and the settings that it shares with other bakes.

use std::path::{Path, PathBuf};

use adumbra::{Bounds, Encoding, Receivers, Sun};
use adumbra_bake::{AssumeGround, BakeOptions, FrameChoice, Size};
use adumbra_program::args::{RunArgs, SceneArgs, SunArgs, parse_bounds, parse_triple};
use adumbra_program::exit::Failure;
use adumbra_program::output::{SCENE, refuse_inputs};
use adumbra_program::progress::Style;
use clap::ValueEnum;

use super::path::PathArgs;
use super::shard::Shard;

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum PresetArg {
    /// 2048 texels: a first look within seconds
    Draft,
    /// 4096 texels
    Low,
    /// 8192 texels
    Medium,
    /// 16384 texels
    High,
    /// 32768 texels
    Ultra,
}

impl PresetArg {
    /// Returns the number of texels on the longest side.
    fn resolution(self) -> u64 {
        match self {
            Self::Draft => 2048,
            Self::Low => 4096,
            Self::Medium => 8192,
            Self::High => 16_384,
            Self::Ultra => 32_768,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FrameArg {
    /// Oblique or light, whichever file a forecast says is smaller; light below 5° of sun
    Auto,
    /// Columns along the light, in a plane across it
    Light,
    /// Columns along the light, over level ground: small where roofs are flat and walls are parallel
    Oblique,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(crate) enum EncodingArg {
    /// With the context coder, in about a third of the bytes.
    Coded,
    /// As it is in memory, for loading without decoding.
    Raw,
}

impl From<EncodingArg> for Encoding {
    fn from(encoding: EncodingArg) -> Self {
        match encoding {
            EncodingArg::Coded => Self::Coded,
            EncodingArg::Raw => Self::Raw,
        }
    }
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum AssumeGroundArg {
    Auto,
    Yes,
    No,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum ReceiversArg {
    /// Every point in space
    All,
    /// Only points on static surfaces (with normals), for filters up to 9: smaller files if nothing moves.
    /// Movers that receive such a file are wrong in 1 to 3 % of their points
    Static,
}

/// Options that determine the result of a bake.
#[derive(clap::Args)]
pub(crate) struct BakeSettings {
    #[command(flatten)]
    pub(crate) sun: SunArgs,
    /// Texels on the longest side: a power of two, 8 to 262144
    ///
    /// The longest side as the sun sees the scene.
    #[arg(long, value_name = "N", conflicts_with = "voxel_size")]
    resolution: Option<u64>,
    /// Edge of a voxel in world units, instead of a resolution
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    voxel_size: Option<f64>,
    /// Preset resolution
    #[arg(long, value_enum, default_value = "medium")]
    preset: PresetArg,
    /// How far below an open surface its shadow may begin, in world units [default: the bias at the surface's
    /// slope]
    ///
    /// Counted along the light. More gives smaller files.
    #[arg(
        long,
        value_name = "LENGTH",
        default_value_t = 0.0,
        hide_default_value = true,
        allow_hyphen_values = true
    )]
    thickness: f64,
    /// How far behind the first surface its shadow may begin, in voxels
    ///
    /// 0 allows anywhere that no filter around a surface reads. A limit, such as 8, keeps contact shadows
    /// dark on movers that touch walls.
    #[arg(long, value_name = "VOXELS", default_value_t = 0)]
    switch_within: u32,
    /// How the file is stored
    ///
    /// coded is about a third of the bytes, and is decoded while it is loaded. Both give the same look-ups,
    /// and convert turns one into the other.
    #[arg(long, value_enum, default_value = "coded")]
    encoding: EncodingArg,
    /// Number of levels of detail, each with voxels four times as large as the one before
    ///
    /// The coarser ones take a third more time and bytes, and are what a reader has first. Levels of fewer
    /// than 256 texels are left out.
    #[arg(long, value_name = "N", default_value_t = BakeOptions::DEFAULT_LEVELS)]
    levels: u32,
    /// Leave out shadows below the last surface
    ///
    /// auto leaves them out if the scene has a ground of its own. no keeps them, for a ground that only the
    /// app draws, and for movers under bridges with nothing below.
    #[arg(long, value_enum, value_name = "auto|yes|no", default_value = "auto", hide_possible_values = true)]
    assume_ground: AssumeGroundArg,
    /// Answer points inside closed solids too
    ///
    /// Without it, the bake chooses freely whether voxels there are lit or shadowed.
    #[arg(long)]
    no_closed_regions: bool,
    /// Which points the file must answer
    #[arg(long, value_enum, default_value = "all")]
    receivers: ReceiversArg,
    /// Cover this box instead of the scene
    ///
    /// Casters outside it towards the sun still cast shadows into it.
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1", allow_hyphen_values = true, value_parser = parse_bounds)]
    bounds: Option<Bounds>,
    /// How the voxels lie in the world
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) frame: FrameArg,
    /// Oblique frame: turn of the grid [default: along most edges]
    ///
    /// The angle from +X to the grid's x axis, towards +Z.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    yaw: Option<f64>,
}

impl BakeSettings {
    /// Checks that the options belong together.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        if self.yaw.is_some() && self.frame != FrameArg::Oblique {
            let frame = self.frame.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned());
            return Err(Failure::Usage(format!(
                "--yaw does not apply to --frame {frame}; remove it, or bake with --frame oblique"
            )));
        }
        Ok(())
    }

    /// Returns the options of a bake under a sun.
    pub(crate) fn options(&self, sun: Sun, ignore_alpha: bool) -> BakeOptions {
        let size = match (self.resolution, self.voxel_size) {
            (Some(n), _) => Size::Resolution(n),
            (None, Some(edge)) => Size::VoxelSize(edge),
            (None, None) => Size::Resolution(self.preset.resolution()),
        };
        BakeOptions::new(sun, size).with(|o| {
            o.frame = match (self.frame, self.yaw) {
                (FrameArg::Auto, _) => FrameChoice::Auto,
                (FrameArg::Light, _) => FrameChoice::Light,
                (FrameArg::Oblique, None) => FrameChoice::Oblique,
                (FrameArg::Oblique, Some(degrees)) => FrameChoice::ObliqueAt(degrees.to_radians()),
            };
            o.thickness_world = self.thickness;
            o.switch_within_voxels = self.switch_within;
            o.levels = self.levels;
            o.encoding = self.encoding.into();
            o.assume_ground = match self.assume_ground {
                AssumeGroundArg::Auto => AssumeGround::Auto,
                AssumeGroundArg::Yes => AssumeGround::Yes,
                AssumeGroundArg::No => AssumeGround::No,
            };
            o.closed_regions = !self.no_closed_regions;
            o.ignore_alpha = ignore_alpha;
            o.receivers = match self.receivers {
                ReceiversArg::All => Receivers::All,
                ReceiversArg::Static => Receivers::Static,
            };
            o.bounds = self.bounds;
        })
    }
}

#[derive(clap::Args)]
pub(crate) struct Bake {
    /// Scene: .glb, .gltf, .obj or .ply
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) settings: BakeSettings,
    #[command(flatten)]
    pub(crate) load: SceneArgs,
    /// The shadow file to write [default: the scene's path with the extension .adumbra; with --regions:
    /// .regions.json]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Also write the shadow file's name into this .glb or .gltf
    ///
    /// Usually the scene itself: into the extras of its first directional light that shines, or of a new one
    /// if it has none. Bevy and three.js load it from there.
    #[arg(long, value_name = "GLTF", conflicts_with = "dry_run")]
    pub(crate) link_in: Option<PathBuf>,
    /// Folder or URL of a bake cache
    ///
    /// A folder is created if it does not exist. A bake reads the parts that have not changed from the cache,
    /// and writes the parts that it bakes to it. After an edit of the scene, only the parts that the edit
    /// touches are baked. The file is the same as without a cache. Any number of bakes may share one. URLs
    /// are s3://bucket/prefix, gs://, az:// or https://, with the usual environment variables, such as
    /// AWS_ACCESS_KEY_ID.
    #[arg(long, value_name = "DIR|URL", conflicts_with = "dry_run")]
    pub(crate) cache: Option<PathBuf>,
    /// Follow the scene's files, and bake again whenever they change
    ///
    /// Only what an edit touches is baked again. The frame is chosen once: the file is that of a fresh bake
    /// with the same frame. Ctrl-C ends it.
    #[arg(long, conflicts_with_all = ["dry_run", "link_in"])]
    pub(crate) watch: bool,
    /// Where the first pages are baked with --watch
    #[arg(long, value_name = "X,Y,Z", requires = "watch", allow_hyphen_values = true, value_parser = parse_triple)]
    pub(crate) focus: Option<[f64; 3]>,
    /// Cut the world into regions of N texels a side, or of 131072, with a file each
    ///
    /// For worlds that are wider than a file can be: voxels may have any size. The output is a manifest,
    /// FILE.json, that names the regions' files in the folder FILE.regions. query, verify and info take it in
    /// place of a file. N is a power of two from 1024 to 131072.
    #[arg(
        long,
        value_name = "N",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "131072",
        conflicts_with_all = ["dry_run", "link_in", "watch", "bounds"]
    )]
    pub(crate) regions: Option<u32>,
    /// Bake one of N shares of the regions, from 0/N to N-1/N
    ///
    /// So that N machines can bake a world, each with its own I. All write the same manifest.
    #[arg(long, value_name = "I/N", requires = "regions")]
    pub(crate) shard: Option<Shard>,
    #[command(flatten)]
    pub(crate) path: PathArgs,
    /// Forecast what the bake would take, and write nothing
    ///
    /// The forecast extrapolates from a few root blocks.
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// How to show progress
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) progress: Style,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

const LINK_IN: &str = "the glTF file of --link-in";

impl Bake {
    /// Returns the files that are read, or written beside the shadow file, with their names in errors.
    pub(crate) fn other_files(&self) -> Vec<(&'static str, &Path)> {
        let paths = [
            (SCENE, Some(&self.scene)),
            ("the edits", self.load.edit()),
            ("the suns", self.path.suns.as_ref()),
            (LINK_IN, self.link_in.as_ref()),
            ("the cache", self.cache.as_ref()),
        ];
        paths.into_iter().filter_map(|(what, path)| Some((what, path?.as_path()))).collect()
    }

    /// Checks that no file is written over another one that the bake reads or writes.
    pub(crate) fn check_paths(&self, output: &Path) -> Result<(), Failure> {
        refuse_inputs("--output", output, self.other_files())?;
        if let Some(gltf) = &self.link_in {
            // The list contains the glTF file itself, which may also be the scene.
            let others = self.other_files().into_iter().filter(|(what, _)| ![SCENE, LINK_IN].contains(what));
            refuse_inputs("--link-in", gltf, others)?;
        }
        Ok(())
    }
}
