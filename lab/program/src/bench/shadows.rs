//! `adumbra-lab bench shadows`: error and cost of the shadows of a few scenes, in one table.

use std::fmt::Write as _;

use adumbra::Sun;
use adumbra_program::exit::Code;
use adumbra_program::output::{make_folder, note_input};
use adumbra_program::scene::load_scene;
use adumbra_render::{Gpu, Renderer, SceneOptions, TechniqueSpec};
use adumbra_scene::{Camera, LoadOptions, Scene};

use super::peers::scene_file;
use crate::TECHNIQUES;
use crate::args::BenchShadows;
use adumbra_compare::Result;
use adumbra_compare::args::ReferenceArg;
use adumbra_compare::baked::{BakeOnDemand, BakedFiles};
use adumbra_compare::compare::{Contender, Reference, camera_figures, compare, walk};
use adumbra_compare::contenders::{contenders, parse};
use adumbra_compare::paths::CameraPath;
use adumbra_compare::report::Report;
use adumbra_compare::truth::{
    Cache, Key, StreetOptions, TruthTracer, scene_key, street_camera, truth_camera,
};
use adumbra_program::format::percent;

/// Angular diameter of the sun's disc as seen from the earth, in degrees, and rays per pixel.
const DISC: (f64, u32) = (0.53, 64);
/// Height of a person's eyes in metres.
const EYE_HEIGHT: f64 = 1.7;
/// Picture size, in pixels, along the path on which shimmer is measured.
const PATH_SIZE: [u32; 2] = [640, 360];
/// Metres travelled along the street, and metres risen by the end.
///
/// This is about five centimetres per frame: a runner's speed at 60 frames per second.
const WALK: [f64; 2] = [0.4, 0.2];
/// Direction towards the sun of the scene whose costs are compared.
const COST_SUN: [f64; 3] = [0.5, 0.8, 0.35];

pub(super) fn run(args: &BenchShadows) -> Result<Code> {
    let specs = parse(TECHNIQUES, &args.shadow)?;
    make_folder(&args.common.output)?;
    let mut reports = Vec::new();
    for name in &args.names {
        reports.extend(measure(args, name, &specs)?);
        write(args, &reports)?;
    }
    if !args.cost_shadow.is_empty() {
        reports.extend(cost(args)?);
        write(args, &reports)?;
    }
    super::say_tables(&args.common.output, "shadows");
    Ok(Code::Fine)
}

/// A scene on the device, with all that its techniques and their reference need.
struct Stage<'a, 's> {
    args: &'a BenchShadows,
    name: &'a str,
    renderer: Renderer,
    truth: &'a TruthTracer<'s>,
    sun: Sun,
    files: BakedFiles,
    cache: Cache,
    key: Key,
    contenders: Vec<Contender>,
}

/// Measures a scene from its truth camera and from the street, with shimmer along a walk on the street.
fn measure(args: &BenchShadows, name: &str, specs: &[TechniqueSpec]) -> Result<Vec<Report>> {
    let truth = args.common.truth.join(format!("{name}.npz"));
    note_input("the truth file itself", &truth);
    let (camera, sun) = truth_camera(&truth)?;
    let scene = load(args, name)?;
    let truth = TruthTracer::build(&scene, false);
    let mut stage = Stage::new(args, name, &scene, &truth, sun, specs)?;
    let [width, height] = args.size;
    let options = StreetOptions { eye_height_world: EYE_HEIGHT, fov_degrees: 60.0, width, height };
    let street = street_camera(&truth, sun.towards(), &options)?;
    let walk = CameraPath::fly(&street, WALK[0], WALK[1], args.path_frames);
    Ok(vec![
        stage.report("truth camera", &Camera { width, height, ..camera }, None)?,
        stage.report("street", &street, Some(&walk))?,
    ])
}

/// Measures the cost of the shadows of a very large scene.
fn cost(args: &BenchShadows) -> Result<Vec<Report>> {
    let specs = parse(TECHNIQUES, &args.cost_shadow)?;
    let sun = Sun::from_direction(COST_SUN)?;
    let scene = load(args, &args.cost_scene)?;
    let truth = TruthTracer::build(&scene, false);
    let [width, height] = args.size;
    let overview = Camera { width, height, ..Camera::overview(&scene.bounds(), 45.0) };
    let options = StreetOptions { eye_height_world: EYE_HEIGHT, fov_degrees: 60.0, width, height };
    let street = street_camera(&truth, sun.towards(), &options)?;
    let mut stage = Stage::new(args, &args.cost_scene, &scene, &truth, sun, &specs)?;
    Ok(vec![stage.report("overview", &overview, None)?, stage.report("street", &street, None)?])
}

fn load(args: &BenchShadows, name: &str) -> Result<Scene> {
    let options = LoadOptions { color_textures: true, ..LoadOptions::default() };
    Ok(load_scene(&scene_file(&args.common.scenes, name)?, &options)?)
}

impl<'a, 's> Stage<'a, 's> {
    fn new(
        args: &'a BenchShadows,
        name: &'a str,
        scene: &'s Scene,
        truth: &'a TruthTracer<'s>,
        sun: Sun,
        specs: &[TechniqueSpec],
    ) -> Result<Self> {
        let gpu = Gpu::request(&args.common.device.gpu_options())?;
        let renderer = Renderer::new(gpu, scene, SceneOptions::default())?;
        let mut files = args.common.cube.files();
        let how = BakeOnDemand {
            scene,
            sun,
            ignore_alpha: false,
            resolution: args.common.resolutions.resolution,
            max_memory_bytes: None,
        };
        files.complete(specs, &how)?;
        let contenders = contenders(&renderer, specs, files.baked(), ReferenceArg::Technique)?;
        let (cache, key) = (args.cache.cache(&args.common.output), scene_key(scene, false));
        Ok(Self { args, name, renderer, truth, sun, files, cache, key, contenders })
    }

    fn report(&mut self, what: &str, camera: &Camera, path: Option<&CameraPath>) -> Result<Report> {
        let towards_sun = self.sun.towards();
        let (truth, cache, scene) = (self.truth, &self.cache, &self.key);
        let reference = Reference { truth, cache, scene, towards_sun, disc: DISC };
        let (renderer, contenders) = (&mut self.renderer, &mut self.contenders);
        let comparison = compare(renderer, &reference, camera, contenders, self.args.frames)?;
        let path = match path {
            Some(path) => Some(walk(renderer, &reference, path, PATH_SIZE, contenders)?),
            None => None,
        };
        for c in &comparison.compared {
            let row = &c.row;
            adumbra_program::note!(
                "{}, {what}, {}: {} % wrong",
                self.name,
                row.name,
                percent(row.wrong(), 3)
            );
        }
        Ok(Report {
            adapter: renderer.gpu().name(),
            software: renderer.gpu().is_software(),
            scene: self.name.to_owned(),
            camera: camera_figures(what, camera),
            sun: towards_sun,
            sun_origin: None,
            sun_degrees: DISC.0,
            sun_samples: DISC.1,
            frames: self.args.frames,
            pixels: comparison.pixels,
            baked: self.files.figures(),
            missing_features: renderer.gpu().missing_features().into_iter().map(str::to_owned).collect(),
            techniques: comparison.compared.into_iter().map(|c| c.row).collect(),
            path,
            sweep: None,
        })
    }
}

/// Writes the reports measured so far.
fn write(args: &BenchShadows, reports: &[Report]) -> Result<()> {
    let mut text = String::from("# Shadows compared with the truth\n\n");
    text.push_str(&summary(reports));
    for report in reports {
        text.push_str(&report.markdown().replacen("# ", "## ", 1).replace("\n## ", "\n### "));
        text.push('\n');
    }
    super::write(&args.common.output, "shadows", &text, &reports)
}

/// Returns a table of every technique's wrong pixels by scene and camera.
fn summary(reports: &[Report]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for row in reports.iter().flat_map(|r| &r.techniques) {
        if !names.contains(&row.name.as_str()) {
            names.push(&row.name);
        }
    }
    let mut text = String::from(
        "Wrong pixels in % of the compared pixels; in brackets, mean |shadow factor - truth| in %.\n\n| technique |",
    );
    for r in reports {
        // Writing to a `String` never fails.
        let _ = write!(text, " {}, {} |", r.scene, r.camera.name);
    }
    let _ = write!(text, "\n|---|{}\n", "---|".repeat(reports.len()));
    for name in names {
        let _ = write!(text, "| `{name}` |");
        for report in reports {
            let cell = report.techniques.iter().find(|t| t.name == name).map_or_else(String::new, |t| {
                format!("{} ({})", percent(t.wrong(), 3), percent(t.mean_difference, 2))
            });
            let _ = write!(text, " {cell} |");
        }
        text.push('\n');
    }
    text + "\n"
}
