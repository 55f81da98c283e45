//! Arguments of `view`: the initial state of its window.

use std::path::PathBuf;

use adumbra_compare::args::DeviceArgs;
use adumbra_program::args::{SceneArgs, SunArgs, parse_bytes};

use adumbra_compare::verbs::render::{CameraArgs, LayerArg};

pub(super) const AFTER_HELP: &str = "Drop a scene, a shadow file or a camera on the window to open it. A script is a JSON array of user actions, \
    played one after the other: commands such as {\"layer\": \"shadow\"}, {\"shadow\": {\"side\": \"second\", \"technique\": \"csm\"}}, {\"key\": \"t\"}, \
    {\"drop\": \"other.glb\"}, {\"resize\": [800, 600]}, {\"screenshot\": \"a.png\"}, \"quit\", and waits: {\"wait\": \"loaded\"}, \"baked\", \"landed\", \"traced\", \
    \"ball\", {\"frames\": 3}, {\"seconds\": 1}, {\"size\": [800, 600]}, {\"message\": \"text\"}.\n\n\
    Example: adumbra view city.glb\n\n\
    Example: adumbra view city.glb --shadow-file city.adumbra --shadow voxel:filter=9 --shadow csm --split 0.5 --layer shadow";

#[derive(clap::Args)]
pub(crate) struct View {
    /// Scene: .glb, .gltf, .obj or .ply
    pub(crate) scene: PathBuf,
    /// The file whose shadows to show, or a path file, whose day is played; a bake begins when the sun moves
    /// [default: baked in the background, coarse to fine]
    #[arg(long, value_name = "FILE")]
    pub(crate) shadow_file: Option<PathBuf>,
    /// Follow the files of the scene and the shadow file, and show what they become
    ///
    /// After an edit of the scene, only what it touches is baked again.
    #[arg(long)]
    pub(crate) watch: bool,
    /// A technique, as for render; the second one given is for the other side [default: voxel, and csm]
    #[arg(long, value_name = "NAME[:KEY=VALUE...]")]
    pub(crate) shadow: Vec<String>,
    /// Ambient occlusion, as for render
    #[arg(long, value_name = "NAME[:KEY=VALUE...]", default_value = "none")]
    pub(crate) ao: String,
    /// What to show
    #[arg(long, value_enum, default_value = "color")]
    pub(crate) layer: LayerArg,
    /// Show both sides, with the divider at this share of the width
    #[arg(long, value_name = "SHARE", conflicts_with = "difference")]
    pub(crate) split: Option<f64>,
    /// Show where both sides differ, multiplied by this: red = the second is darker, blue = brighter
    #[arg(long, value_name = "TIMES", num_args = 0..=1, default_missing_value = "2")]
    pub(crate) difference: Option<f32>,
    #[command(flatten)]
    pub(crate) sun: SunArgs,
    /// A camera (.json) saved by the viewer, instead of --eye, --target and --fov
    #[arg(long, value_name = "FILE", conflicts_with_all = ["eye", "target", "fov", "ortho"])]
    pub(crate) camera: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) view: CameraArgs,
    /// Samples per pixel along each axis
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=4))]
    pub(crate) antialias: u32,
    /// A rolling ball, as for render
    #[arg(long = "move", value_name = "MOVER", allow_hyphen_values = true)]
    pub(crate) mover: Option<String>,
    /// Time in seconds since the ball and the scene's animations began
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) time: f64,
    /// Let time run: that of the day, the ball and the animations
    #[arg(long)]
    pub(crate) play: bool,
    /// A day to play, as for bake --sun-path; its shadows are baked ahead of its sun
    #[arg(long, value_name = "DAY", conflicts_with_all = ["sun", "azimuth", "elevation", "shadow_file"])]
    pub(crate) day: Option<String>,
    /// Day, or path file: seconds that 24 hours take, from 48 to real time, 86400
    #[arg(long, value_name = "SECONDS", default_value_t = 2880.0)]
    pub(crate) day_length: f64,
    /// Day: bake only what is so near to the camera, along x and z; a large world is not baked in time
    /// otherwise
    #[arg(long, value_name = "WORLD", requires = "day")]
    pub(crate) day_near: Option<f64>,
    /// Day, or path file: hour by the local clock at which it begins [default: at its first sun]
    #[arg(long, value_name = "HOUR")]
    pub(crate) hour: Option<f64>,
    /// Show the space that the shadow file covers, as lines
    #[arg(long = "box")]
    pub(crate) show_box: bool,
    /// Begin without the panel
    #[arg(long)]
    pub(crate) no_panel: bool,
    /// Draw continuously, for steady times, not only when something changed
    #[arg(long)]
    pub(crate) continuous: bool,
    /// Finest resolution of a bake in the background: texels on the longest side
    #[arg(long, value_name = "N", default_value_t = 8192)]
    pub(crate) resolution: u64,
    /// Budget of shadow files: one whose words need more MiB is streamed
    #[arg(long, value_name = "MIB", default_value_t = 32)]
    pub(crate) budget: u64,
    /// Frames over which pages of a streamed file come and go; 0 changes them at once
    #[arg(long, value_name = "FRAMES", default_value_t = 0, value_parser = clap::value_parser!(u32).range(..=600))]
    pub(crate) fade: u32,
    /// Memory that a bake in the background, or loading a scene, may hold, such as 2GiB [default: no limit
    /// for bakes; for loading 2 GiB plus 64 bytes for each byte of the scene's files]
    #[arg(long, value_name = "SIZE", value_parser = parse_bytes)]
    pub(crate) max_memory: Option<u64>,
    /// Play a JSON file of commands as if a user gave them
    #[arg(long, value_name = "FILE")]
    pub(crate) script: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
    #[command(flatten)]
    pub(crate) load: SceneArgs,
}
