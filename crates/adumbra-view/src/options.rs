//! The options that a view starts with. All of them can be given on a command line.

use std::path::PathBuf;

use adumbra::Sun;
use adumbra_render::{GpuOptions, SpecText, TechniqueSpec};
use adumbra_scene::{LoadOptions, Projection};
use adumbra_truth::movers::MoveSpec;

use crate::day::DayOptions;
use crate::script::Script;
use crate::settings::Shown;

/// The options that a view starts with.
pub struct ViewOptions {
    /// The scene.
    pub scene: PathBuf,
    /// How scenes are loaded, including dropped ones.
    pub load: LoadOptions,
    /// A shadow file that replaces a bake. A bake starts when the sun moves. The file is used again when the
    /// sun returns.
    pub shadow_file: Option<PathBuf>,
    /// Whether to load the scene and the shadow file again when their files change.
    pub watch: bool,
    /// Shadow techniques of both sides. The defaults are `voxel`, which reads the shadow file, and cascades.
    pub shadows: [Option<TechniqueSpec>; 2],
    /// Ambient occlusion.
    pub ambient: SpecText,
    /// Name of a layer, as in `adumbra render --layer`.
    pub layer: String,
    /// How both sides are shown.
    pub shown: Shown,
    /// The sun. The default is the shadow file's, or the scene's first directional light that shines, or the
    /// usual one.
    pub sun: Option<Sun>,
    /// Camera position. The default is a position from which the whole scene is visible.
    pub eye: Option<[f64; 3]>,
    /// Point at the centre of the view. The default is the scene's centre.
    pub target: Option<[f64; 3]>,
    /// The camera's projection.
    pub projection: Projection,
    /// Width and height of the picture, in pixels.
    pub size: [u32; 2],
    /// Samples per pixel along each side.
    pub antialias: u32,
    /// Specification of a rolling ball.
    pub ball: Option<MoveSpec>,
    /// The text from which `ball` was parsed.
    pub ball_text: Option<String>,
    /// Seconds since all movements began.
    pub seconds: f64,
    /// Whether time runs.
    pub playing: bool,
    /// Whether the bounds of the shadow file's space are drawn as lines.
    pub show_box: bool,
    /// Whether the panel is shown.
    pub show_panel: bool,
    /// Whether frames are drawn continuously, or only when something changed.
    pub continuous: bool,
    /// Resolution of bakes, in texels on the longest side.
    pub resolution: u64,
    /// Budget of shadow files in MiB: a file that needs more is streamed.
    pub budget_mib: u64,
    /// Number of frames over which pages of a streamed file fade in and out; 0 switches them at once.
    pub fade_frames: u32,
    /// Memory limit of a bake, in bytes.
    pub max_memory_bytes: Option<u64>,
    /// Options for selecting the device.
    pub gpu: GpuOptions,
    /// Further arguments of the command line that reproduces a view: how scenes are loaded, and the device.
    pub repeated: Vec<String>,
    /// Other files that were read, such as the script. No picture and no camera may overwrite them.
    pub inputs: Vec<PathBuf>,
    /// A day to play. Its sun replaces `sun`. If the shadow file is a sun path, only the day's length and
    /// hour apply, and the day needs no text.
    pub day: Option<DayOptions>,
    /// Script to play.
    pub script: Option<Script>,
}
