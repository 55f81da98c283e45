//! Arguments of `compare` and `bench peers`.

use std::path::PathBuf;

use clap::ValueEnum;

use super::render::{CameraArgs, DeviceArgs};
use super::{CacheArgs, SceneArgs, SunArgs, WorkArgs};
use crate::exit::Failure;

#[derive(clap::Args)]
pub(crate) struct Compare {
    /// Scene: .glb, .gltf, .obj or .ply
    pub(crate) scene: PathBuf,
    /// A technique, as for render; repeated
    #[arg(long, value_name = "NAME[:KEY=VALUE...]", required = true)]
    pub(crate) shadow: Vec<String>,
    /// `overview`, `street` (eye above the ground, chosen by rays), a camera (.json) that the viewer saved, or a truth file (.npz)
    /// with a camera and a sun [default: --eye and --target, or overview]
    #[arg(long, value_name = "CAMERA", conflicts_with_all = ["eye", "target", "ortho"])]
    pub(crate) camera: Option<String>,
    #[command(flatten)]
    pub(crate) view: CameraArgs,
    /// Of a street camera, metres above the ground
    #[arg(long, value_name = "METRES", default_value_t = 1.7)]
    pub(crate) eye_height: f64,
    /// Frames that each median is taken of
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) frames: u32,
    #[command(flatten)]
    pub(crate) sun: SunArgs,
    /// Full angle of the sun's disc that soft techniques are judged by, degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 0.53)]
    pub(crate) sun_angle: f64,
    /// Rays a pixel towards that disc
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=65_536))]
    pub(crate) sun_samples: u32,
    /// Which truth judges
    #[arg(long, value_enum, default_value = "technique")]
    pub(crate) judge: JudgeArg,
    #[command(flatten)]
    pub(crate) baked: BakedArgs,
    /// Walk a camera path too: a JSON file, `orbit` (around the scene) or `fly` (ahead from the camera and up)
    #[arg(long, value_name = "PATH")]
    pub(crate) path: Option<String>,
    /// Frames of the path [default: the file's, or 60]
    #[arg(long, value_name = "N", requires = "path", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) path_frames: Option<u32>,
    #[command(flatten)]
    pub(crate) cache: CacheArgs,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
    #[command(flatten)]
    pub(crate) load: SceneArgs,
    /// Exit code 1 where GPU and rays see different surfaces at more than 1 % of the pixels with a surface
    #[arg(long)]
    pub(crate) strict: bool,
    /// Folder for report.md, report.json, sheet.png and the pictures
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    /// Print the report as one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum JudgeArg {
    /// The sun's disc for pcss, voxel:soft and the blurs of the screen, its middle for all others
    Technique,
    /// The sun's middle
    Hard,
    /// The sun's disc
    Disc,
}

/// Where voxel techniques look up.
#[derive(clap::Args)]
pub(crate) struct BakedArgs {
    /// A shadow file for the voxel techniques; one light-aligned and one world-aligned may be given [default: baked on the way]
    #[arg(long, value_name = "FILE")]
    pub(crate) shadow_file: Vec<PathBuf>,
    /// Of a light-aligned file baked on the way: texels on the longest side
    #[arg(long, value_name = "N", default_value_t = 16384)]
    pub(crate) resolution: u64,
    /// Of a world-aligned file baked on the way: voxels along the cube's side
    #[arg(long, value_name = "N", default_value_t = 2048)]
    pub(crate) cube_resolution: u64,
}

#[derive(clap::Args)]
pub(crate) struct BenchPeers {
    /// Folder of scenes
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: PathBuf,
    /// Folder of truth files, NAME.npz each
    #[arg(long, value_name = "DIR")]
    pub(crate) truth: PathBuf,
    /// A technique, as for render; may be repeated [default: every one, and voxel filters]
    #[arg(long, value_name = "NAME[:KEY=VALUE...]")]
    pub(crate) shadow: Vec<String>,
    /// Of the light-aligned files: texels on the longest side
    #[arg(long, value_name = "N", default_value_t = 16384)]
    pub(crate) resolution: u64,
    /// Of the world-aligned files: voxels along the cube's side
    #[arg(long, value_name = "N", default_value_t = 2048)]
    pub(crate) cube_resolution: u64,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
    /// Where peers.md and peers.json go
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

impl Compare {
    /// Whether the numbers make sense.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        if !(self.sun_angle > 0.0 && self.sun_angle <= 180.0) {
            let angle = self.sun_angle;
            return Err(Failure::Usage(format!("--sun-angle {angle}: give degrees above 0 and at most 180")));
        }
        if !(self.eye_height > 0.0 && self.eye_height.is_finite()) {
            return Err(Failure::Usage(format!("--eye-height {}: give a height above 0", self.eye_height)));
        }
        if self.view.size.iter().any(|s| *s < 11) {
            return Err(Failure::Usage("--size: structural similarity needs 11 pixels a side".to_owned()));
        }
        Ok(())
    }
}
