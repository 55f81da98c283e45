//! Arguments of `render`, and of cameras and devices wherever they are asked for.

use std::path::PathBuf;

use adumbra::camera::{Camera, Projection};
use adumbra::scene::Bounds;
use adumbra_render::occlusion::{OCCLUSIONS, occlusion_options, occlusion_parameters};
use adumbra_render::technique::parameter_texts;
use adumbra_render::{Features, GpuOptions, TECHNIQUES, parameters};
use clap::ValueEnum;

use super::{BiasArgs, SceneArgs, SunArgs, WeightsArg, WorkArgs, parse_size, parse_triple};
use crate::exit::Failure;

/// What `render` ends its help with: the techniques, and the ways to ambient occlusion.
pub(super) fn after_help() -> String {
    let width = TECHNIQUES.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let list: String = TECHNIQUES
        .iter()
        .map(|(name, what)| {
            let told = parameters(name);
            let told = if told.is_empty() { told } else { format!("  {:width$}    {told}\n", "") };
            format!("  {name:width$}  {what}\n{told}")
        })
        .collect();
    let lines = |lines: Vec<String>| -> String { lines.iter().map(|l| format!("{:13}{l}\n", "")).collect() };
    let occlusions: String = OCCLUSIONS
        .iter()
        .map(|(name, what)| format!("  {name:9}{what}\n{}", lines(occlusion_parameters(name))))
        .collect();
    let options = lines(occlusion_options());
    let texts: String = parameter_texts().iter().map(|t| format!("  {t}\n")).collect();
    format!(
        "Techniques:\n{list}\nTheir parameters:\n{texts}\nAmbient occlusion:\n{occlusions}  each of them, but truth and none:\n{options}\nExample: adumbra render city.glb --shadow-file city.adumbra --eye 120,60,120 --target 0,5,0 -o city.png\nExample: \
         adumbra render city.glb --shadow csm:cascades=4:filter=5 --layer shadow -o shadow.exr\nExample: \
         adumbra render city.glb --shadow csm --ao issao:radius=4 -o city.png"
    )
}

#[derive(clap::Args)]
pub(crate) struct Render {
    /// Scene: .glb, .gltf, .obj or .ply
    pub(crate) scene: PathBuf,
    /// How shadows are made, see below; may be repeated, one picture each [default: the shadow file's, or rays]
    #[arg(long, value_name = "NAME[:KEY=VALUE...]")]
    pub(crate) shadow: Vec<String>,
    /// The file whose shadows to draw
    #[arg(long, value_name = "FILE")]
    pub(crate) shadow_file: Option<PathBuf>,
    /// Ambient occlusion, of the light of the sky alone: ssao, hbao, alchemy, issao, gtao, truth or none, see below
    #[arg(long, value_name = "NAME[:KEY=VALUE...]", default_value = "none")]
    pub(crate) ao: String,
    /// Trace the shadows, as --shadow truth
    #[arg(long, conflicts_with_all = ["diff", "shadow"])]
    pub(crate) truth: bool,
    /// Mark where file and rays differ: red = lit called shadowed, blue = shadowed called lit; on the CPU
    #[arg(long, requires = "shadow_file", conflicts_with = "shadow")]
    pub(crate) diff: bool,
    /// What to draw
    #[arg(long, value_enum, default_value = "color")]
    pub(crate) layer: LayerArg,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
    #[command(flatten)]
    pub(crate) sun: SunArgs,
    #[command(flatten)]
    pub(crate) camera: CameraArgs,
    /// Something that moves: sphere[:radius=R][:from=X,Y,Z:to=X,Y,Z][:seconds=S]. Without from and to the ball goes from the sun into
    /// a shade, and the camera looks at it where --eye and --target do not say otherwise; may be repeated
    #[arg(long = "move", value_name = "MOVER", allow_hyphen_values = true)]
    pub(crate) movers: Vec<String>,
    /// Seconds since movers and the scene's animations began
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, conflicts_with = "frames")]
    pub(crate) time: f64,
    /// Draw this many pictures, from the beginning of all movements to their end: NAME.0000.png and so on
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=9999))]
    pub(crate) frames: Option<u32>,
    /// Filter width in texels: 1, 3, 5, 9 or 17; of a world-aligned file K × K × K voxels: 1, 3 or 5
    #[arg(long, value_name = "K", default_value_t = 5, conflicts_with = "shadow")]
    pub(crate) filter: u32,
    /// How a world-aligned file's taps are weighted
    #[arg(long, value_enum, default_value = "mean", conflicts_with = "shadow")]
    pub(crate) weights: WeightsArg,
    /// Samples a pixel along each axis
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=16))]
    pub(crate) antialias: u32,
    #[command(flatten)]
    pub(crate) load: SceneArgs,
    #[command(flatten)]
    pub(crate) bias: BiasArgs,
    /// The PNG to write, or an EXR with raw values: linear colours, view depth, normals, visibilities, cascade or level (of voxels log2 of their edge)
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// What of a frame is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum LayerArg {
    /// The finished picture
    Color,
    /// The shadow factor: white = lit
    Shadow,
    /// Ambient visibility: white = unoccluded
    Ao,
    /// Distance along the view
    Depth,
    /// World normals
    Normal,
    /// The picture, coloured by cascade
    Cascades,
    /// The picture, coloured by the level of a hybrid map that answers: red the finest, then orange, green, blue
    HrsmLevels,
    /// The picture, coloured by the size of the block of a baked file that answers: purple a single voxel, then blue, green,
    /// yellow and orange; a legend gives metres
    VoxelSize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum DeviceArg {
    /// The GPU, or the CPU where there is no adapter; rays alone (`--truth`, `--diff`) are the CPU's
    Auto,
    /// The GPU, or an error
    Gpu,
    /// The CPU
    Cpu,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum WithoutArg {
    /// GPU timestamps
    Timestamps,
    /// Filtering of 32-bit floats
    Float32Filtering,
    /// Depth clip control
    DepthClipControl,
}

/// Where frames are drawn.
#[derive(clap::Args)]
pub(crate) struct DeviceArgs {
    /// Where to draw
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) device: DeviceArg,
    /// Part of the GPU adapter's name [default: the first real GPU, or else a software adapter]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Do as if the device lacked this; may be repeated
    #[arg(long, value_enum, value_name = "FEATURE")]
    without: Vec<WithoutArg>,
}

impl DeviceArgs {
    /// Whether the CPU may draw where there is no adapter: no other was asked for.
    pub(crate) fn may_fall_back(&self) -> bool {
        self.device == DeviceArg::Auto && self.adapter.is_none()
    }

    /// Whether only a GPU will do.
    pub(crate) fn wants_gpu(&self) -> bool {
        self.device == DeviceArg::Gpu || self.device == DeviceArg::Auto && self.adapter.is_some()
    }

    /// Which adapter was asked for, and what it is to do without, as words of a command.
    pub(crate) fn words(&self) -> Vec<String> {
        let adapter = self.adapter.iter().map(|name| format!("--adapter '{}'", name.replace('\'', "'\\''")));
        let without = self.without.iter().filter_map(ValueEnum::to_possible_value);
        adapter.chain(without.map(|v| format!("--without {}", v.get_name()))).collect()
    }

    pub(crate) fn gpu_options(&self) -> GpuOptions {
        let without = self.without.iter().map(|w| match w {
            WithoutArg::Timestamps => Features::TIMESTAMP_QUERY | Features::TIMESTAMP_QUERY_INSIDE_ENCODERS,
            WithoutArg::Float32Filtering => Features::FLOAT32_FILTERABLE,
            WithoutArg::DepthClipControl => Features::DEPTH_CLIP_CONTROL,
        });
        GpuOptions {
            adapter: self.adapter.clone(),
            without: without.fold(Features::empty(), |a, b| a | b),
            ..GpuOptions::default()
        }
    }
}

/// Where a scene is seen from.
#[derive(clap::Args)]
pub(crate) struct CameraArgs {
    /// Camera position [default: the scene from above at an angle]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = parse_triple)]
    pub(crate) eye: Option<[f64; 3]>,
    /// Point in the middle of the picture [default: the scene's centre]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = parse_triple)]
    pub(crate) target: Option<[f64; 3]>,
    /// Vertical field of view, degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 45.0)]
    pub(crate) fov: f64,
    /// An orthographic camera that sees this height, in place of a field of view
    #[arg(long, value_name = "METRES", conflicts_with = "fov")]
    pub(crate) ortho: Option<f64>,
    /// Pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub(crate) size: [u32; 2],
}

impl CameraArgs {
    /// How points are projected.
    pub(crate) fn projection(&self) -> Result<Projection, Failure> {
        if !(self.fov > 0.0 && self.fov < 180.0) {
            return Err(Failure::Usage(format!("--fov {}: give degrees between 0 and 180", self.fov)));
        }
        Ok(match self.ortho {
            Some(height) if !(height > 0.0 && height.is_finite()) => {
                return Err(Failure::Usage(format!("--ortho {height}: give a height above 0")));
            }
            Some(height_world) => Projection::Orthographic { height_world },
            None => Projection::Perspective { fov_degrees: self.fov },
        })
    }

    /// The camera on a scene within `bounds`; `view` is where it stands and looks where the user does not say, if not so as to see
    /// the whole scene.
    pub(crate) fn camera(&self, bounds: &Bounds, view: Option<[[f64; 3]; 2]>) -> Result<Camera, Failure> {
        let projection = self.projection()?;
        let [width, height] = self.size;
        let whole = Camera::overview(bounds, self.fov);
        let [eye, target] = view.unwrap_or([whole.eye, whole.target]);
        let (eye, target) = (self.eye.unwrap_or(eye), self.target.unwrap_or(target));
        if eye == target || !eye.iter().chain(&target).all(|c| c.is_finite()) {
            return Err(Failure::Usage(
                "--eye and --target must be finite and two different points".to_owned(),
            ));
        }
        Ok(Camera { eye, target, projection, width, height })
    }
}
