//! Arguments of `render`, and the camera options of all verbs that take them.

use std::path::PathBuf;

use crate::args::{DeviceArgs, ResolutionArgs};
use adumbra::Bounds;
use adumbra_program::args::{RunArgs, SceneArgs, SunArgs, parse_size, parse_triple};
use adumbra_program::exit::Failure;
use adumbra_program::lookup::LookupArgs;
use adumbra_program::moment::TimeArg;
use adumbra_render::Techniques;
use adumbra_render::occlusion::{OCCLUSIONS, occlusion_options, occlusion_parameters};
use adumbra_scene::{Camera, Projection};
use clap::ValueEnum;

/// Returns the text at the end of the help of `render`: the techniques and the kinds of ambient occlusion.
/// `program` is the name of the program.
pub fn after_help(program: &str, techniques: Techniques) -> String {
    let width = techniques.iter().map(|t| t.name.len()).max().unwrap_or(0);
    let list: String = techniques
        .iter()
        .map(|t| {
            let (name, summary, taken) = (t.name, t.summary, techniques.parameters(t.name));
            let taken = if taken.is_empty() { taken } else { format!("  {:width$}    {taken}\n", "") };
            format!("  {name:width$}  {summary}\n{taken}")
        })
        .collect();
    let lines = |lines: Vec<String>| -> String { lines.iter().map(|l| format!("{:13}{l}\n", "")).collect() };
    let occlusions: String = OCCLUSIONS
        .iter()
        .map(|(name, what)| format!("  {name:9}{what}\n{}", lines(occlusion_parameters(name))))
        .collect();
    let options = lines(occlusion_options());
    let texts: String = techniques.parameter_texts().iter().map(|t| format!("  {t}\n")).collect();
    format!(
        "Techniques:\n{list}\nTheir parameters:\n{texts}\nAmbient occlusion:\n{occlusions}  all of them except truth and none:\n{options}\nExample: {program} render city.glb --shadow-file city.adumbra --eye 120,60,120 --target 0,5,0 -o city.png\nExample: \
         {program} render city.glb --shadow csm:cascades=4:filter=5 --layer shadow -o shadow.exr\nExample: \
         {program} render city.glb --shadow voxel --resolution 8192 -o city.png\nExample: \
         {program} render city.glb --shadow csm --ao issao:radius=4 -o city.png"
    )
}

/// The arguments of `render`.
#[derive(clap::Args)]
#[command(
    mut_arg("filter", |filter| filter.default_value("5").conflicts_with("shadow")),
    mut_arg("resolution", |resolution| resolution.default_value("4096")),
    mut_arg("json", |json| json.help("Print one JSON object; for several pictures, one that lists them"))
)]
pub struct Render {
    /// Scene: .glb, .gltf, .obj or .ply
    pub scene: PathBuf,
    /// How shadows are made, see below; may be repeated, one picture each [default: the shadow file's, or
    /// rays with --truth]
    #[arg(long, value_name = "NAME[:KEY=VALUE...]")]
    pub shadow: Vec<String>,
    /// The file whose shadows to draw [default: if a technique of --shadow needs one, it is baked]
    #[arg(long, value_name = "FILE")]
    pub shadow_file: Option<PathBuf>,
    /// The moment to draw of a sun path: by its local clock, such as 12:30, or its seconds
    #[arg(long, value_name = "TIME", requires = "shadow_file")]
    pub sun_time: Option<TimeArg>,
    /// Resolution of files that are baked as needed.
    #[command(flatten)]
    pub resolutions: ResolutionArgs,
    /// Ambient occlusion, which affects only the light of the sky: ssao, hbao, alchemy, issao, gtao, truth or
    /// none, see below
    #[arg(long, value_name = "NAME[:KEY=VALUE...]", default_value = "none")]
    pub ao: String,
    /// Trace the shadows, like --shadow truth
    #[arg(long, conflicts_with_all = ["diff", "shadow"])]
    pub truth: bool,
    /// Mark where file and rays differ: red = lit called shadowed, blue = shadowed called lit; drawn on the
    /// CPU
    #[arg(long, requires = "shadow_file", conflicts_with = "shadow")]
    pub diff: bool,
    /// What to draw
    #[arg(long, value_enum, default_value = "color")]
    pub layer: LayerArg,
    /// Device.
    #[command(flatten)]
    pub device: DeviceArgs,
    /// Sun.
    #[command(flatten)]
    pub sun: SunArgs,
    /// Camera.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// A moving object: sphere, then any of :radius=R, :from=X,Y,Z:to=X,Y,Z and :seconds=S; may be repeated.
    /// Without from and to the ball rolls out of the sun into a shadow. The camera looks at the first one
    /// unless --eye and --target say otherwise
    #[arg(long = "move", value_name = "MOVER", allow_hyphen_values = true)]
    pub movers: Vec<String>,
    /// Time in seconds since the movers and the scene's animations began
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, conflicts_with = "frames")]
    pub time: f64,
    /// Draw this many pictures, from the beginning of all movements to their end: NAME.0000.png and so on
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=9999))]
    pub frames: Option<u32>,
    /// Look-up.
    #[command(flatten)]
    pub lookup: LookupArgs,
    /// Samples per pixel along each axis
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=16))]
    pub antialias: u32,
    /// Loading of the scene.
    #[command(flatten)]
    pub load: SceneArgs,
    /// The PNG to write, or an EXR with raw values: linear colours, view depth, normals, visibilities,
    /// cascade or level (for voxels log2 of the block's edge)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Run.
    #[command(flatten)]
    pub run: RunArgs,
}

/// The part of a frame that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LayerArg {
    /// The finished picture
    Color,
    /// The shadow factor: white = lit
    Shadow,
    /// Ambient visibility: white = unoccluded
    Ao,
    /// Distance along the view direction
    Depth,
    /// World-space normals
    Normal,
    /// The picture, coloured by cascade
    Cascades,
    /// The picture, coloured by the level of the hybrid map that answers: red is the finest, then orange,
    /// green, blue
    HrsmLevels,
    /// The picture, coloured by the size of the block of the baked file that answers: purple is a single
    /// voxel, then blue, green, yellow and orange; a legend gives its edge in world units
    VoxelSize,
    /// The picture, coloured by the coarsest level of detail of the shadow file whose texels are not larger
    /// than a pixel: red is the finest, then orange, green, blue
    Level,
}

/// The camera that a scene is seen from.
#[derive(clap::Args)]
pub struct CameraArgs {
    /// Camera position [default: obliquely above the scene]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = parse_triple)]
    pub eye: Option<[f64; 3]>,
    /// Point in the middle of the picture [default: the scene's centre]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = parse_triple)]
    pub target: Option<[f64; 3]>,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 45.0)]
    pub fov: f64,
    /// Use an orthographic camera that sees this height in world units, instead of a field of view
    #[arg(long, value_name = "LENGTH", conflicts_with = "fov")]
    pub ortho: Option<f64>,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub size: [u32; 2],
}

impl CameraArgs {
    /// Returns how points are projected.
    ///
    /// # Errors
    ///
    /// Returns [`Failure::Usage`] for an angle or a height that is out of its range.
    pub fn projection(&self) -> Result<Projection, Failure> {
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

    /// Returns the camera on a scene within `bounds`. `view` is the eye and the target to use if the user
    /// gives none. Without it the default camera sees the whole scene.
    ///
    /// # Errors
    ///
    /// Returns [`Failure::Usage`] if eye and target are no two finite points.
    pub fn camera(&self, bounds: &Bounds, view: Option<[[f64; 3]; 2]>) -> Result<Camera, Failure> {
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
