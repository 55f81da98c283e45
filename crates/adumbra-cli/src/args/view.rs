//! Arguments of `view`: everything that its window can be set to.

use std::path::PathBuf;

use super::render::{CameraArgs, DeviceArgs, LayerArg};
use super::{SceneArgs, SunArgs};

pub(super) const AFTER_HELP: &str = "Drop a scene, a shadow file or a camera on the window to open it. A script is a JSON array of what a user does, \
    played one after the other: commands such as {\"layer\": \"shadow\"}, {\"shadow\": {\"side\": \"second\", \"technique\": \"csm\"}}, {\"key\": \"t\"}, \
    {\"drop\": \"other.glb\"}, {\"resize\": [800, 600]}, {\"screenshot\": \"a.png\"}, \"quit\", and waits: {\"wait\": \"loaded\"}, \"baked\", \"landed\", \"traced\", \
    \"ball\", {\"frames\": 3}, {\"seconds\": 1}, {\"size\": [800, 600]}, {\"message\": \"text\"}.\n\n\
    Example: adumbra view city.glb\n\n\
    Example: adumbra view city.glb --shadow-file city.adumbra --shadow voxel:filter=9 --shadow csm --split 0.5 --layer shadow";

#[derive(clap::Args)]
pub(crate) struct View {
    /// Scene: .glb, .gltf, .obj or .ply
    pub(crate) scene: PathBuf,
    /// The file whose shadows to show, or given twice one of each kind; a bake begins where the sun moves [default: baked behind the window,
    /// coarse to fine]
    #[arg(long, value_name = "FILE")]
    pub(crate) shadow_file: Vec<PathBuf>,
    /// A technique, as for render; given twice, the second is the other side's [default: the file's, and csm]
    #[arg(long, value_name = "NAME[:KEY=VALUE...]")]
    pub(crate) shadow: Vec<String>,
    /// Ambient occlusion, as for render
    #[arg(long, value_name = "NAME[:KEY=VALUE...]", default_value = "none")]
    pub(crate) ao: String,
    /// What to show
    #[arg(long, value_enum, default_value = "color")]
    pub(crate) layer: LayerArg,
    /// Both sides, with the divider at this share of the width
    #[arg(long, value_name = "SHARE", conflicts_with = "difference")]
    pub(crate) split: Option<f64>,
    /// Where both sides differ, multiplied by this: red = the second is darker, blue = brighter
    #[arg(long, value_name = "TIMES", num_args = 0..=1, default_missing_value = "2")]
    pub(crate) difference: Option<f32>,
    #[command(flatten)]
    pub(crate) sun: SunArgs,
    /// A camera (.json) that a view saved, in place of --eye, --target and --fov
    #[arg(long, value_name = "FILE", conflicts_with_all = ["eye", "target", "fov", "ortho"])]
    pub(crate) camera: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) view: CameraArgs,
    /// Samples a pixel along each axis
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=4))]
    pub(crate) antialias: u32,
    /// A ball that rolls, as for render
    #[arg(long = "move", value_name = "MOVER", allow_hyphen_values = true)]
    pub(crate) mover: Option<String>,
    /// Seconds since the ball and the scene's animations began
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) time: f64,
    /// Let time go on
    #[arg(long)]
    pub(crate) play: bool,
    /// Show the shadow file's space as lines
    #[arg(long = "box")]
    pub(crate) show_box: bool,
    /// Begin without the panel
    #[arg(long)]
    pub(crate) no_panel: bool,
    /// Draw on and on, for steady times, not only where something changed
    #[arg(long)]
    pub(crate) continuous: bool,
    /// Texels on the longest side that a bake behind the window goes to
    #[arg(long, value_name = "N", default_value_t = 8192)]
    pub(crate) resolution: u64,
    /// Memory that such a bake, or loading a scene, may hold, such as 2GiB [default: no limit for bakes; for loading 2 GiB, and 64 bytes
    /// for each byte of the scene's files]
    #[arg(long, value_name = "SIZE", value_parser = super::parse_bytes)]
    pub(crate) max_memory: Option<u64>,
    /// Play what a JSON file says, as if a user did it
    #[arg(long, value_name = "FILE")]
    pub(crate) script: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
    #[command(flatten)]
    pub(crate) load: SceneArgs,
}
