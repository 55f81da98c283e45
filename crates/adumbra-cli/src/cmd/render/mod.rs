//! `adumbra render`: pictures on the GPU with any technique, or on the CPU with a file's shadows or rays.

mod ambient;
mod cpu;
mod gpu;
pub(super) mod layers;
mod legend;
mod movers;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use adumbra::camera::Camera;
use adumbra::format::AnyFile;
use adumbra::light::Sun;
use adumbra::scene::{MoverPolicy, Scene};
use adumbra_render::{Gpu, RenderError, TechniqueSpec};
use serde_json::{Value, json};

use self::ambient::Ambient;
use super::lookup::{ignored_alpha, sun_of};
use super::{load_scene, print_json, with_threads};
use crate::args::{DeviceArg, LayerArg, Render};
use crate::exit::{Code, Failure, Outcome};
use crate::output::{note_input, refuse_inputs, refuse_read, refuse_same};

/// What every picture of a call is drawn from.
struct Job<'a> {
    args: &'a Render,
    /// Movers included.
    scene: Scene,
    camera: Camera,
    /// Seconds and number of each picture.
    moments: Vec<(f64, Option<u32>)>,
    file: Option<AnyFile>,
    ambient: Option<Ambient>,
    sun: Sun,
    ignore_alpha: bool,
}

pub(crate) fn run(args: &Render) -> Outcome {
    let mut specs: Vec<TechniqueSpec> = args.shadow.iter().map(|s| s.parse()).collect::<Result<_, _>>()?;
    if let Some((i, spec)) = specs.iter().enumerate().find(|(i, s)| specs[..*i].contains(s)) {
        return Err(Failure::Usage(format!("--shadow {spec}: it is asked for twice (number {})", i + 1)));
    }
    let ending = args.output.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    if !["png", "exr"].contains(&ending.as_str()) {
        let output = args.output.display();
        return Err(Failure::Usage(format!("--output {output}: give a path that ends in .png or .exr")));
    }
    let mut ambient = Ambient::read(&args.ao)?;
    if args.layer == LayerArg::Ao && ambient.is_none() {
        return Err(Failure::Usage("--layer ao: say how it is made: --ao NAME, see --help".to_owned()));
    }
    if let Some(path) = &args.shadow_file {
        note_input("the shadow file itself", path);
    }
    let file = args.shadow_file.as_deref().map(AnyFile::read).transpose()?;
    if file.is_some() && args.sun.is_given() {
        return Err(Failure::Usage("--sun: the shadow file was baked for a sun of its own".to_owned()));
    }
    if specs.is_empty() && file.is_none() && !args.truth {
        if args.layer == LayerArg::Ao {
            // No shadow is seen in it.
            specs.push("none".parse()?);
        } else {
            return Err(Failure::Usage(
                "say how shadows are made: --shadow-file FILE, --shadow NAME, or --truth".to_owned(),
            ));
        }
    }
    let mut load = args.load.load_options(args.work.max_memory)?;
    load.color_textures = true;
    if load.movers == MoverPolicy::LeaveOut {
        load.movers = MoverPolicy::Keep;
    }
    load.ignore_alpha |= file.as_ref().is_some_and(ignored_alpha);
    let sun = match &file {
        Some(file) => sun_of(file),
        None => args.sun.sun()?,
    };
    with_threads(args.work.threads, || {
        let mut scene = load_scene(&args.scene, &load)?;
        let ignore_alpha = load.ignore_alpha;
        let view = movers::add(args, &mut scene, sun.towards(), ignore_alpha)?;
        let camera = args.camera.camera(&scene.bounds(), view)?;
        let moments = movers::moments(args, &scene)?;
        if let Some(ambient) = &mut ambient {
            ambient.set_radius(scene.usual_diagonal());
        }
        let job = Job { args, scene, camera, moments, file, ambient, sun, ignore_alpha };
        job.draw(&specs)
    })
}

impl Job<'_> {
    /// No picture goes where the scene or the shadow file lies.
    fn check_outputs(&self, specs: &[TechniqueSpec]) -> Result<(), Failure> {
        let output = &self.args.output;
        // The path itself too: the CPU draws there where no GPU is found.
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
        refuse_same(all.iter().map(|path| &**path))
    }

    fn draw(&self, specs: &[TechniqueSpec]) -> Outcome {
        self.check_outputs(specs)?;
        let traced_only = self.args.truth || !specs.is_empty() && specs.iter().all(|s| s.name() == "truth");
        let is_color = self.args.layer == LayerArg::Color;
        let plain = is_color && !layers::is_exr(&self.args.output) && self.ambient.is_none();
        let device = &self.args.device;
        if self.args.diff && device.wants_gpu() {
            return Err(Failure::Usage(
                "--diff: the CPU draws it; leave out --device gpu and --adapter".to_owned(),
            ));
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
                let whose = if self.file.is_some() { "the file's shadows" } else { "traced shadows" };
                eprintln!("note: {error}; drawing on the CPU with {whose}");
                self.on_the_cpu(&[])?;
            }
            Err(error) => return Err(error.into()),
        }
        Ok(Code::Fine)
    }

    fn on_the_cpu(&self, specs: &[TechniqueSpec]) -> Result<(), Failure> {
        if let Some(other) = specs.iter().find(|s| s.name() != "truth") {
            return Err(Failure::Usage(format!(
                "--shadow {other}: the CPU draws a file's shadows (--shadow-file alone) and truth"
            )));
        }
        if let Some(ambient) = &self.ambient {
            return Err(Failure::Usage(format!(
                "--ao {}: the CPU draws open sky alone; ambient occlusion needs a GPU adapter, a software one will do",
                ambient.name()
            )));
        }
        if self.args.layer != LayerArg::Color || layers::is_exr(&self.args.output) {
            return Err(Failure::Usage(
                "the CPU draws color alone, as PNG; other layers and EXR need a GPU adapter, a software one will do"
                    .to_owned(),
            ));
        }
        let truth = self.args.truth || !specs.is_empty() || self.file.is_none();
        cpu::draw(self, truth, &self.args.output)
    }

    /// The scene with everything where it is at a time.
    fn scene_at(&self, seconds: f64) -> Cow<'_, Scene> {
        if self.scene.movers.is_empty() {
            return Cow::Borrowed(&self.scene);
        }
        let mut scene = self.scene.clone();
        scene.pose(seconds);
        Cow::Owned(scene)
    }

    fn report(&self, output: &Path, size: [u32; 2], mut more: Value) {
        let [width, height] = size;
        if !self.args.json {
            return say!("{}: {width} x {height}", output.display());
        }
        more["output"] = json!(output.display().to_string());
        more["width"] = json!(width);
        more["height"] = json!(height);
        print_json(&more);
    }
}

/// Where a technique's picture goes: the path given, or beside it with the technique's name where there are several.
fn output_of(path: &Path, spec: &TechniqueSpec, several: bool) -> PathBuf {
    if !several {
        return path.to_owned();
    }
    let stem = path.file_stem().and_then(|s| s.to_str()).unwrap_or("picture");
    let ending = path.extension().and_then(|s| s.to_str()).unwrap_or("png");
    let name = name_in_paths(&spec.to_string());
    path.with_file_name(format!("{stem}.{name}.{ending}"))
}

/// A technique's name, as a part of a file's.
pub(super) fn name_in_paths(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || "-.+=".contains(c) { c } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_pictures_get_their_technique_s_name() {
        let spec: TechniqueSpec = "csm:cascades=4:size=2048".parse().unwrap();
        let path = Path::new("out/a.png");
        assert_eq!(output_of(path, &spec, false), path);
        assert_eq!(output_of(path, &spec, true), Path::new("out/a.csm_cascades=4_size=2048.png"));
    }
}
