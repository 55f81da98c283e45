//! The verb `render`: draws pictures on the GPU with any technique, or on the CPU with a file's shadows or
//! traced shadows.

mod ambient;
mod args;
mod cpu;
mod gpu;
mod legend;
mod movers;

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::args::DeviceArg;
use crate::{Result, layers};
use adumbra_program::exit::{Code, Failure};
use adumbra_program::output::{print_json, refuse_inputs, refuse_read, refuse_same};
use adumbra_program::say;
use adumbra_program::scene::load_scene_within;
use adumbra_program::sun::{ChosenSun, SunOrigin, SunSource};
use adumbra_program::threads::with_threads;
use adumbra_render::{Gpu, RenderError, TechniqueSpec};
use adumbra_scene::{Camera, MoverPolicy, Scene};
use schemars::JsonSchema;
use serde::Serialize;

use self::ambient::Ambient;
pub use args::{CameraArgs, LayerArg, Render, after_help};

use crate::baked::BakedFiles;
use crate::verbs::Offer;

/// What is printed with `--json`.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Printed {
    /// One picture.
    One(Picture),
    /// Several.
    Several(Pictures),
}

/// One picture. Fields of the CPU are absent if the GPU drew it, and vice versa.
#[derive(Serialize, JsonSchema)]
pub struct Picture {
    /// The picture's file.
    output: String,
    /// Number of pixels per row.
    width: u32,
    /// Number of rows of pixels.
    height: u32,
    /// The device that drew the picture: `cpu`, or the adapter's name.
    device: String,
    /// Unit vector towards the sun.
    sun: [f64; 3],
    /// Where the sun comes from.
    sun_origin: SunOrigin,
    /// Model of the processor.
    #[serde(flatten)]
    cpu: Option<cpu::CpuFigures>,
    #[serde(flatten)]
    gpu: Option<Box<gpu::GpuFigures>>,
}

/// The pictures of a call that draws more than one.
#[derive(Serialize, JsonSchema)]
pub struct Pictures {
    /// The pictures, in the order in which they were drawn.
    pictures: Vec<Picture>,
}

/// Figures of a picture besides its size, by the device that drew it.
enum Figures {
    Cpu(cpu::CpuFigures),
    Gpu(Box<gpu::GpuFigures>),
}

/// Everything that all pictures of a call share.
struct Job<'a> {
    args: &'a Render,
    /// The scene, including its movers.
    scene: Scene,
    camera: Camera,
    /// Seconds and number of each picture.
    moments: Vec<(f64, Option<u32>)>,
    files: BakedFiles,
    offer: Offer<'a>,
    ambient: Option<Ambient>,
    sun: ChosenSun,
    ignore_alpha: bool,
    /// With `--json`, one object for each picture that is written.
    pictures: Mutex<Vec<Picture>>,
}

/// Runs the verb.
///
/// # Errors
///
/// Returns an error for wrong arguments, inputs that cannot be read, and a device that fails.
pub fn run(args: &Render, offer: Offer<'_>) -> Result<Code> {
    let mut specs: Vec<TechniqueSpec> =
        args.shadow.iter().map(|s| offer.techniques.parse(s)).collect::<Result<_, _>>()?;
    if let Some((i, spec)) = specs.iter().enumerate().find(|(i, s)| specs[..*i].contains(s)) {
        return Err(Failure::Usage(format!("--shadow {spec}: it is given twice (number {})", i + 1)).into());
    }
    let ending = args.output.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    if !["png", "exr"].contains(&ending.as_str()) {
        let output = args.output.display();
        return Err(
            Failure::Usage(format!("--output {output}: give a path that ends in .png or .exr")).into()
        );
    }
    let mut ambient = Ambient::read(&args.ao)?;
    if args.layer == LayerArg::Ao && ambient.is_none() {
        return Err(Failure::Usage(
            "--layer ao: choose the ambient occlusion with --ao NAME; see --help".to_owned(),
        )
        .into());
    }
    let limit = args.run.memory_limit();
    let files = BakedFiles::read_at(args.shadow_file.as_slice(), args.sun_time, limit, (offer.more_files)())?;
    if files.is_given() && args.sun.is_given() {
        return Err(Failure::Usage(
            "--sun: the shadow file determines the sun; remove the option".to_owned(),
        )
        .into());
    }
    if specs.is_empty() && !files.is_given() && !args.truth {
        if args.layer == LayerArg::Ao {
            // This layer shows no shadows.
            specs.push("none".parse()?);
        } else {
            return Err(Failure::Usage(
                "choose the shadows with --shadow-file FILE, --shadow NAME or --truth".to_owned(),
            )
            .into());
        }
    }
    let mut load = args.load.load_options()?;
    load.color_textures = true;
    if load.movers == MoverPolicy::Skip {
        load.movers = MoverPolicy::Keep;
    }
    if let Some(scene) = files.scene() {
        load.follow(scene, &args.scene);
    }
    // Reject an invalid sun before loading the scene.
    args.sun.given_for(&args.scene, &args.load)?;
    with_threads(args.run.threads, || {
        let mut scene = load_scene_within(args.run.memory_limit(), &args.scene, &load)?;
        let sun = match files.sun() {
            Some(sun) => ChosenSun::from_source(sun, SunSource::ShadowFile),
            None => args.sun.choose(&scene, &args.scene)?,
        };
        let ignore_alpha = load.ignore_alpha;
        let view = movers::add(args, &mut scene, sun.sun.towards(), ignore_alpha)?;
        let camera = args.camera.camera(&scene.bounds(), view)?;
        let moments = movers::moments(args, &scene)?;
        if let Some(ambient) = &mut ambient {
            ambient.set_radius(scene.usual_diagonal());
        }
        let job = Job {
            args,
            scene,
            camera,
            moments,
            files,
            offer,
            ambient,
            sun,
            ignore_alpha,
            pictures: Mutex::default(),
        };
        let code = job.draw(&specs)?;
        job.print_pictures()?;
        Ok(code)
    })?
}

impl Job<'_> {
    /// Refuses outputs that would replace the scene or the shadow file.
    fn check_outputs(&self, specs: &[TechniqueSpec]) -> Result<()> {
        let output = &self.args.output;
        // Also the path itself: the CPU draws there if no GPU is found.
        let plain = (specs.len() != 1).then(|| output.clone());
        let each = specs.iter().map(|spec| output_of(output, spec, specs.len() > 1)).chain(plain);
        let numbered =
            |path: PathBuf| self.moments.iter().map(move |&(_, number)| movers::numbered(&path, number));
        let all: Vec<PathBuf> = each.flat_map(numbered).collect();
        for path in &all {
            let file = self.args.shadow_file.as_deref().map(|file| ("the shadow file itself", file));
            refuse_inputs("--output", path, file)?;
            refuse_read("--output", path)?;
        }
        Ok(refuse_same(all.iter().map(|path| &**path))?)
    }

    fn draw(&self, specs: &[TechniqueSpec]) -> Result<Code> {
        self.check_outputs(specs)?;
        let traced_only = self.args.truth || !specs.is_empty() && specs.iter().all(TechniqueSpec::is_traced);
        let is_color = self.args.layer == LayerArg::Color;
        let plain = is_color && !layers::is_exr(&self.args.output) && self.ambient.is_none();
        let device = &self.args.device;
        if self.args.diff && device.wants_gpu() {
            return Err(Failure::Usage(
                "--diff: it is drawn on the CPU; remove --device gpu and --adapter".to_owned(),
            )
            .into());
        }
        let by_rays_alone = self.args.diff || traced_only && plain && !device.wants_gpu();
        if by_rays_alone || device.device == DeviceArg::Cpu {
            self.on_the_cpu(specs)?;
            return Ok(Code::Fine);
        }
        match Gpu::request(&device.gpu_options()) {
            Ok(gpu) if self.args.truth => gpu::draw(self, gpu, &["truth".parse()?])?,
            Ok(gpu) => gpu::draw(self, gpu, specs)?,
            Err(error @ RenderError::NoAdapter { .. })
                if device.may_fall_back() && self.ambient.is_none() =>
            {
                let whose = if self.files.is_given() { "the file's shadows" } else { "traced shadows" };
                adumbra_program::note!("note: {error}; drawing on the CPU with {whose}");
                self.on_the_cpu(&[])?;
            }
            Err(error) => return Err(error.into()),
        }
        Ok(Code::Fine)
    }

    fn on_the_cpu(&self, specs: &[TechniqueSpec]) -> Result<()> {
        if let Some(other) = specs.iter().find(|s| !s.is_traced()) {
            return Err(Failure::Usage(format!(
                "--shadow {other}: the CPU draws only truth and, without --shadow, the shadows of --shadow-file"
            ))
            .into());
        }
        if let Some(ambient) = &self.ambient {
            return Err(Failure::Usage(format!(
                "--ao {}: the CPU does not draw ambient occlusion; it needs a GPU adapter, and a software adapter is enough",
                ambient.name()
            )).into());
        }
        if self.args.layer != LayerArg::Color || layers::is_exr(&self.args.output) {
            return Err(Failure::Usage(
                "the CPU draws only the layer color, as PNG; other layers and EXR need a GPU adapter, and a software adapter is enough"
                    .to_owned(),
            ).into());
        }
        let truth = self.args.truth || !specs.is_empty() || !self.files.is_given();
        cpu::draw(self, truth, &self.args.output)
    }

    /// Returns the scene with all movers at their positions at a time.
    fn scene_at(&self, seconds: f64) -> Cow<'_, Scene> {
        if self.scene.movers.is_empty() {
            return Cow::Borrowed(&self.scene);
        }
        let mut scene = self.scene.clone();
        scene.pose(seconds);
        Cow::Owned(scene)
    }

    fn report(&self, output: &Path, size: [u32; 2], device: String, figures: Figures) {
        let [width, height] = size;
        if !self.args.run.json {
            return say!("{}: {width} x {height}, {}", output.display(), self.sun);
        }
        let (cpu, gpu) = match figures {
            Figures::Cpu(figures) => (Some(figures), None),
            Figures::Gpu(figures) => (None, Some(figures)),
        };
        let picture = Picture {
            output: output.display().to_string(),
            width,
            height,
            device,
            sun: self.sun.sun.towards(),
            sun_origin: self.sun.origin.clone(),
            cpu,
            gpu,
        };
        self.pictures.lock().unwrap_or_else(PoisonError::into_inner).push(picture);
    }

    /// Prints the object of a single picture, or one that lists the objects of several.
    fn print_pictures(&self) -> Result<(), Failure> {
        let mut pictures = std::mem::take(&mut *self.pictures.lock().unwrap_or_else(PoisonError::into_inner));
        match pictures.len() {
            0 => Ok(()),
            1 => print_json(&Printed::One(pictures.remove(0))),
            _ => print_json(&Printed::Several(Pictures { pictures })),
        }
    }
}

/// Returns the path of a technique's picture: the given path, or with several techniques one next to it with
/// the technique's name.
fn output_of(path: &Path, spec: &TechniqueSpec, several: bool) -> PathBuf {
    if !several {
        return path.to_owned();
    }
    let stem = path.file_stem().and_then(|s| s.to_str()).unwrap_or("picture");
    let ending = path.extension().and_then(|s| s.to_str()).unwrap_or("png");
    let name = name_in_paths(&spec.to_string());
    path.with_file_name(format!("{stem}.{name}.{ending}"))
}

/// Returns a technique's name in a form that can be part of a file name.
pub(super) fn name_in_paths(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || "-.+=".contains(c) { c } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_several_pictures_after_their_techniques() {
        let spec: TechniqueSpec = "csm:cascades=4:size=2048".parse().unwrap();
        let path = Path::new("out/a.png");
        assert_eq!(output_of(path, &spec, false), path);
        assert_eq!(output_of(path, &spec, true), Path::new("out/a.csm_cascades=4_size=2048.png"));
    }
}
