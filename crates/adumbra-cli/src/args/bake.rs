//! What `bake` is told, and what else bakes by its settings.

use std::path::PathBuf;

use adumbra::bake::{DEFAULT_SWITCH_WITHIN, Options, Preset, Size};
use adumbra::format::Layout;
use adumbra::scene::Bounds;
use adumbra::settings::Receivers;
use clap::ValueEnum;

use super::tree::{FrameArg, TreeArgs};
use super::{SceneArgs, SunArgs, WorkArgs, numbers};
use crate::exit::Failure;
use crate::progress::Style;

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum PresetArg {
    /// 2048 texels: a look within seconds
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
    /// Every point in space is answered
    All,
    /// Only points on static surfaces (with normals), filters up to 9; smaller where nothing moves
    Static,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum LayoutArg {
    /// About a third of the bytes
    Packed,
    /// Words of 32 bits
    Plain,
    /// An image of depths: about a quarter of the bytes, and penumbrae (voxel:soft)
    Hierarchy,
    /// Packed or hierarchy, whichever is smaller; the bake builds both
    Auto,
}

/// What decides a bake's result.
#[derive(clap::Args)]
pub(crate) struct BakeSettings {
    #[command(flatten)]
    pub(crate) sun: SunArgs,
    /// A power of two. Light: texels on the longest side in the light's plane, 8 to 262144; world: voxels along the cube's
    /// side, at most 32768
    #[arg(long, value_name = "N", conflicts_with = "voxel_size")]
    resolution: Option<u64>,
    /// Edge of a voxel in metres, in place of a resolution
    #[arg(long, value_name = "METRES", allow_hyphen_values = true)]
    voxel_size: Option<f64>,
    /// A ready-made resolution
    #[arg(long, value_enum)]
    preset: Option<PresetArg>,
    /// How far below an open surface a shadow may begin, metres: smaller files [default: the bias at its slope]
    #[arg(
        long,
        value_name = "METRES",
        default_value_t = 0.0,
        hide_default_value = true,
        allow_hyphen_values = true
    )]
    thickness: f64,
    /// How far behind its first surface a column's shadow may begin, voxels. 0: anywhere inside the solid, for smaller files
    /// and paler contact shadows under filters
    #[arg(long, value_name = "VOXELS", default_value_t = DEFAULT_SWITCH_WITHIN)]
    switch_within: u32,
    /// Shadows are needed below the last surface of a column too (movers under bridges with nothing below)
    #[arg(long)]
    no_assume_ground: bool,
    /// Insides of solids are not free
    #[arg(long)]
    no_closed_regions: bool,
    /// Which points the file must answer
    #[arg(long, value_enum, default_value = "all")]
    receivers: ReceiversArg,
    /// Cover this box in place of the scene; casters outside it but sunward still cast into it
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1", allow_hyphen_values = true, value_parser = parse_bounds)]
    bounds: Option<Bounds>,
    /// How the file holds the voxels [default: packed]
    #[arg(long, value_enum)]
    layout: Option<LayoutArg>,
    #[command(flatten)]
    pub(crate) tree: TreeArgs,
}

impl BakeSettings {
    /// The layout of a light-aligned file; none: the smaller.
    pub(crate) fn layout(&self) -> Option<Layout> {
        match self.layout {
            None | Some(LayoutArg::Packed) => Some(Layout::Packed),
            Some(LayoutArg::Plain) => Some(Layout::Plain),
            Some(LayoutArg::Hierarchy) => Some(Layout::Hierarchy),
            Some(LayoutArg::Auto) => None,
        }
    }

    /// Options that only the light frame knows, and whether they were given.
    /// The layouts that the plain builder does not make; their option's value, if it was given.
    pub(super) fn fast_only_layout(&self) -> Option<&'static str> {
        match self.layout {
            Some(LayoutArg::Hierarchy) => Some("hierarchy"),
            Some(LayoutArg::Auto) => Some("auto"),
            _ => None,
        }
    }

    pub(super) fn light_only(&self) -> [(bool, &'static str); 5] {
        [
            (self.thickness != 0.0, "--thickness"),
            (self.no_assume_ground, "--no-assume-ground"),
            (matches!(self.receivers, ReceiversArg::Static), "--receivers static"),
            (self.switch_within != DEFAULT_SWITCH_WITHIN, "--switch-within"),
            (self.layout.is_some(), "--layout"),
        ]
    }

    pub(crate) fn options(&self, ignore_alpha: bool, work: &WorkArgs) -> Result<Options, Failure> {
        let preset = match self.preset {
            Some(PresetArg::Draft) => Preset::Draft,
            Some(PresetArg::Low) => Preset::Low,
            None if self.tree.frame == FrameArg::World => Preset::Draft,
            None | Some(PresetArg::Medium) => Preset::Medium,
            Some(PresetArg::High) => Preset::High,
            Some(PresetArg::Ultra) => Preset::Ultra,
        };
        let size = match (self.resolution, self.voxel_size) {
            (Some(n), _) => Size::Resolution(n),
            (None, Some(metres)) => Size::VoxelSize(metres),
            (None, None) => Size::Resolution(preset.resolution().into()),
        };
        Ok(Options {
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
            max_memory_bytes: work.max_memory,
            builder: self.tree.light_builder(),
            ..Options::new(self.sun.sun()?, size)
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
    /// The shadow file to write [default: the scene's name with .adumbra]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Draw a few tiles and say what the bake would take; writes nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// How to show progress
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) progress: Style,
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

fn parse_bounds(text: &str) -> Result<Bounds, String> {
    let [x0, y0, z0, x1, y1, z1] = numbers::<6>(text)?;
    Ok(Bounds { min: [x0, y0, z0], max: [x1, y1, z1] })
}
