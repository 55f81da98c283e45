//! Arguments of `compare`.

use std::path::PathBuf;

use crate::args::{CacheArgs, DeviceArgs, ReferenceArg, ResolutionArgs};
use adumbra_program::args::{RunArgs, SceneArgs, SunArgs};
use adumbra_program::exit::Failure;
use adumbra_solar::Day;

use crate::verbs::render::CameraArgs;

/// Default number of frames of a generated path.
pub const PATH_FRAMES: u32 = 60;

/// The arguments of `compare`.
#[derive(clap::Args)]
#[command(mut_arg("json", |json| json.help("Print the report as one JSON object")))]
pub struct Compare {
    /// Scene: .glb, .gltf, .obj or .ply
    pub scene: PathBuf,
    /// A technique, as for render; may be repeated
    #[arg(long, value_name = "NAME[:KEY=VALUE...]", required = true)]
    pub shadow: Vec<String>,
    /// `overview`, `street` (the eye above the ground at a place found by rays), a camera (.json) saved by
    /// the viewer, or a truth file (.npz) with a camera and a sun [default: --eye and --target, or overview]
    #[arg(long, value_name = "CAMERA", conflicts_with_all = ["eye", "target", "ortho"])]
    pub camera: Option<String>,
    /// Camera.
    #[command(flatten)]
    pub view: CameraArgs,
    /// Height of a street camera above the ground, in world units
    #[arg(long, value_name = "LENGTH", default_value_t = 1.7)]
    pub eye_height: f64,
    /// Number of frames that each median is taken over
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub frames: u32,
    /// Sun.
    #[command(flatten)]
    pub sun: SunArgs,
    /// Angular diameter in degrees of the sun's disc that soft techniques are compared with
    #[arg(long, value_name = "DEGREES", default_value_t = 0.53)]
    pub sun_degrees: f64,
    /// Rays per pixel towards the sun's disc
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=65_536))]
    pub sun_samples: u32,
    /// Which truth the techniques are compared with
    #[arg(long, value_enum, default_value = "technique")]
    pub reference: ReferenceArg,
    /// A shadow file for the techniques that read one [default: baked as needed]
    #[arg(long, value_name = "FILE")]
    pub shadow_file: Vec<PathBuf>,
    /// Resolution of files that are baked as needed.
    #[command(flatten)]
    pub resolutions: ResolutionArgs,
    /// Also walk a camera path: a JSON file, `orbit` (around the scene) or `fly` (ahead from the camera and
    /// up)
    #[arg(long, value_name = "PATH")]
    pub path: Option<String>,
    /// Number of frames of the path [default: the file's, or 60]
    #[arg(long, value_name = "N", requires = "path", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub path_frames: Option<u32>,
    /// Also move the sun while the camera stands still: across a day of a place, as for bake --sun-path, or
    /// without DAY across the sun path that is the shadow file
    #[arg(long, value_name = "DAY", num_args = 0..=1, conflicts_with_all = ["path", "sun", "azimuth", "elevation"])]
    pub sun_sweep: Option<Option<Day>>,
    /// Number of steps of that sun, of equal time
    #[arg(
        long,
        value_name = "N",
        default_value_t = 600,
        requires = "sun_sweep",
        value_parser = clap::value_parser!(u32).range(2..=100_000)
    )]
    pub sweep_steps: u32,
    /// Cache of traced truth.
    #[command(flatten)]
    pub cache: CacheArgs,
    /// Device.
    #[command(flatten)]
    pub device: DeviceArgs,
    /// Loading of the scene.
    #[command(flatten)]
    pub load: SceneArgs,
    /// Exit with code 1 if GPU and rays see different surfaces at more than 1 % of the pixels with a surface
    #[arg(long)]
    pub check_surfaces: bool,
    /// Folder for report.md, report.json, sheet.png and the pictures
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Run.
    #[command(flatten)]
    pub run: RunArgs,
}

impl Compare {
    /// Checks the ranges of the numbers.
    ///
    /// # Errors
    ///
    /// Returns [`Failure::Usage`] for the first number that is out of its range.
    pub fn check(&self) -> Result<(), Failure> {
        if !(self.sun_degrees > 0.0 && self.sun_degrees <= 180.0) {
            let degrees = self.sun_degrees;
            return Err(Failure::Usage(format!(
                "--sun-degrees {degrees}: give degrees above 0 and at most 180"
            )));
        }
        if !(self.eye_height > 0.0 && self.eye_height.is_finite()) {
            return Err(Failure::Usage(format!("--eye-height {}: give a height above 0", self.eye_height)));
        }
        if self.view.size.iter().any(|s| *s < 11) {
            return Err(Failure::Usage(
                "--size: structural similarity needs at least 11 pixels per side".to_owned(),
            ));
        }
        Ok(())
    }
}
