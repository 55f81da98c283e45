//! Arguments of `bake`, and the settings that it shares with other bakes.

use std::path::PathBuf;

use adumbra::{Bounds, Receivers, Sun};
use adumbra_bake::{BakeOptions, Builder, LayoutChoice, Preset, Size};
use adumbra_program::args::{LayoutArg, RunArgs, SceneArgs, SunArgs, numbers};
use adumbra_program::exit::Failure;
use adumbra_program::progress::Style;
use adumbra_tree::TreeOptions;
use clap::ValueEnum;

use super::tree::TreeArgs;

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

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum ReceiversArg {
    /// Every point in space
    All,
    /// Only points on static surfaces (with normals), for filters up to 9: smaller files if nothing moves. Movers that
    /// receive such a file are wrong in 1 to 3 % of their points
    Static,
}

/// Options that determine the result of a bake.
#[derive(clap::Args)]
pub(crate) struct BakeSettings {
    #[command(flatten)]
    pub(crate) sun: SunArgs,
    /// Texels on the longest side: a power of two, 8 to 262144
    ///
    /// The longest side as the sun sees the scene. World frame: voxels along the cube's side, at most 32768.
    #[arg(long, value_name = "N", conflicts_with = "voxel_size")]
    resolution: Option<u64>,
    /// Edge of a voxel in metres, instead of a resolution
    #[arg(long, value_name = "METRES", allow_hyphen_values = true)]
    voxel_size: Option<f64>,
    /// Preset resolution [default: medium; with --frame world, draft]
    #[arg(long, value_enum)]
    preset: Option<PresetArg>,
    /// How far below an open surface its shadow may begin, in metres along the light [default: the bias at the surface's
    /// slope]
    ///
    /// More gives smaller files.
    #[arg(
        long,
        value_name = "METRES",
        default_value_t = 0.0,
        hide_default_value = true,
        allow_hyphen_values = true
    )]
    thickness: f64,
    /// How far behind the first surface its shadow may begin, in voxels
    ///
    /// 0 allows anywhere that no filter around a surface reads. A limit, such as 8, keeps contact shadows dark on movers
    /// that touch walls.
    #[arg(long, value_name = "VOXELS", default_value_t = 0)]
    switch_within: u32,
    /// Keep shadows below the last surface of a column too
    ///
    /// For movers under bridges with nothing below.
    #[arg(long)]
    no_assume_ground: bool,
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
    /// How the file stores the voxels [default: depths; with --builder plain, packed]
    #[arg(long, value_enum, hide_short_help = true)]
    layout: Option<LayoutArg>,
    #[command(flatten)]
    pub(crate) tree: TreeArgs,
}

impl BakeSettings {
    /// Returns the options that trees do not have, and whether each was given.
    fn columns_only(&self) -> [(bool, &'static str); 5] {
        [
            (self.thickness != 0.0, "--thickness"),
            (self.no_assume_ground, "--no-assume-ground"),
            (matches!(self.receivers, ReceiversArg::Static), "--receivers static"),
            (self.switch_within != 0, "--switch-within"),
            (self.layout.is_some(), "--layout"),
        ]
    }

    /// Returns the options of a light-aligned bake under a sun.
    pub(crate) fn options(&self, sun: Sun, ignore_alpha: bool) -> BakeOptions {
        let preset = match self.preset {
            Some(PresetArg::Draft) => Preset::Draft,
            Some(PresetArg::Low) => Preset::Low,
            None if self.tree.frame.is_world() => Preset::Draft,
            None | Some(PresetArg::Medium) => Preset::Medium,
            Some(PresetArg::High) => Preset::High,
            Some(PresetArg::Ultra) => Preset::Ultra,
        };
        let size = match (self.resolution, self.voxel_size) {
            (Some(n), _) => Size::Resolution(n),
            (None, Some(metres)) => Size::VoxelSize(metres),
            (None, None) => Size::Resolution(preset.resolution().into()),
        };
        BakeOptions {
            frame: self.tree.columns_frame(),
            layout: match (self.layout, self.tree.light_builder()) {
                (Some(layout), _) => layout.into(),
                (None, Builder::Plain) => LayoutChoice::Packed,
                (None, Builder::Fast) => LayoutChoice::default(),
            },
            thickness_world: self.thickness,
            switch_within_voxels: self.switch_within,
            assume_ground: !self.no_assume_ground,
            closed_regions: !self.no_closed_regions,
            ignore_alpha,
            receivers: match self.receivers {
                ReceiversArg::All => Receivers::All,
                ReceiversArg::Static => Receivers::Static,
            },
            bounds: self.bounds,
            builder: self.tree.light_builder(),
            ..BakeOptions::new(sun, size)
        }
    }

    /// Whether the bake is a world-aligned tree. An error if options of both kinds are mixed.
    pub(crate) fn is_tree(&self) -> Result<bool, Failure> {
        self.tree.check(&self.columns_only())?;
        Ok(self.tree.frame.is_world())
    }

    /// Returns the options of a world-aligned bake. Options that both kinds of file share come from `common`.
    pub(crate) fn tree_options(&self, common: &BakeOptions) -> TreeOptions {
        self.tree.options(common)
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
    /// The shadow file to write [default: the scene's path with the extension .adumbra]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Also write the shadow file's name into this .glb or .gltf
    ///
    /// Usually the scene itself: into the extras of its first directional light, or of a new one if it has none. Bevy and
    /// three.js load it from there.
    #[arg(long, value_name = "GLTF", conflicts_with = "dry_run")]
    pub(crate) into: Option<PathBuf>,
    /// Forecast what the bake would take, and write nothing
    ///
    /// The forecast is made of a few tiles that are drawn.
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// How to show progress
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) progress: Style,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

fn parse_bounds(text: &str) -> Result<Bounds, String> {
    let [x0, y0, z0, x1, y1, z1] = numbers::<6>(text)?;
    Ok(Bounds { min: [x0, y0, z0], max: [x1, y1, z1] })
}
