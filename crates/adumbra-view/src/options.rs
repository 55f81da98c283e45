//! What a view begins with; a command line can say all of it.

use std::path::PathBuf;

use adumbra::camera::Projection;
use adumbra::light::Sun;
use adumbra::scene::LoadOptions;
use adumbra_render::movers::MoveSpec;
use adumbra_render::{GpuOptions, TechniqueSpec};

use crate::script::Script;
use crate::settings::Shown;

/// What a view begins with.
pub struct ViewOptions {
    /// The scene.
    pub scene: PathBuf,
    /// How scenes are loaded, those that are dropped too.
    pub load: LoadOptions,
    /// Shadow files, in place of bakes, one of each kind at most; a bake begins where the sun moves, and they are taken again where it
    /// comes back.
    pub shadow_files: Vec<PathBuf>,
    /// Shadow techniques of both sides; the file's, and cascades, where they are not given.
    pub shadows: [Option<TechniqueSpec>; 2],
    /// Ambient occlusion.
    pub ambient: TechniqueSpec,
    /// Name of a layer, as `adumbra render --layer` has it.
    pub layer: String,
    /// How both sides are shown.
    pub shown: Shown,
    /// The sun; none takes the shadow file's, or the usual one.
    pub sun: Option<Sun>,
    /// Camera position; none stands so as to see the whole scene.
    pub eye: Option<[f64; 3]>,
    /// Point in the middle of the view; none looks at the scene's centre.
    pub target: Option<[f64; 3]>,
    /// How points are projected.
    pub projection: Projection,
    /// Width and height of what is shown, pixels.
    pub size: [u32; 2],
    /// Samples a pixel along each side.
    pub antialias: u32,
    /// A ball that rolls, and how.
    pub ball: Option<MoveSpec>,
    /// The same as it was written.
    pub ball_text: Option<String>,
    /// Seconds since all movements began.
    pub seconds: f64,
    /// Whether they go on.
    pub playing: bool,
    /// Whether the shadow file's space is drawn as lines.
    pub show_box: bool,
    /// Whether the panel is there.
    pub show_panel: bool,
    /// Whether frames are drawn on and on, or only where something changed.
    pub continuous: bool,
    /// Texels on the longest side that bakes go to.
    pub resolution: u64,
    /// Bytes that a bake may hold.
    pub max_memory_bytes: Option<u64>,
    /// The device.
    pub gpu: GpuOptions,
    /// What the command that shows a view again has beside its settings: how scenes are loaded, the device.
    pub repeated: Vec<String>,
    /// Other files that were read, such as the script; no picture and no camera replaces them.
    pub inputs: Vec<PathBuf>,
    /// Commands to play.
    pub script: Option<Script>,
}
