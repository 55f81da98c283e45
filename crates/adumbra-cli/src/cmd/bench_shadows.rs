//! `adumbra bench shadows`: what the shadows of a few scenes are worth and what they cost, in one table.

use std::fmt::Write as _;

use adumbra::camera::Camera;
use adumbra::light::Sun;
use adumbra::scene::{LoadOptions, Scene};
use adumbra_lab::compare::{Contender, Judge, camera_figures, compare, walk};
use adumbra_lab::paths::CameraPath;
use adumbra_lab::report::{Report, percent};
use adumbra_lab::truth::{Cache, Key, StreetOptions, TruthTracer, scene_key, street_camera, truth_camera};
use adumbra_render::{Gpu, Renderer, SceneOptions, TechniqueSpec};

use super::baked::{BakeOnTheWay, BakedFiles};
use super::bench_peers::scene_file;
use super::compare::{contenders, parse};
use super::load_scene;
use crate::args::{BenchShadows, JudgeArg};
use crate::exit::{Code, Failure, Outcome};
use crate::output::{make_folder, note_input, write_whole};

/// The sun's disc as seen from the earth, and rays a pixel.
const DISC: (f64, u32) = (0.53, 64);
/// Height of a person's eyes, metres.
const EYE_HEIGHT: f64 = 1.7;
/// Pictures of the path that shimmer is measured along.
const PATH_SIZE: [u32; 2] = [640, 360];
/// Metres walked along the street, and metres risen at the end: about five centimetres a frame, a runner at 60 frames a second.
const WALK: [f64; 2] = [0.4, 0.2];
/// Of the scene whose costs are compared.
const COST_SUN: [f64; 3] = [0.5, 0.8, 0.35];

pub(super) fn run(args: &BenchShadows) -> Outcome {
    let specs = parse(&args.shadow)?;
    make_folder(&args.output)?;
    let mut reports = Vec::new();
    for name in &args.names {
        reports.extend(measure(args, name, &specs)?);
        write(args, &reports)?;
    }
    if !args.cost_shadow.is_empty() {
        reports.extend(cost(args)?);
        write(args, &reports)?;
    }
    say!("{}", args.output.join("shadows.md").display());
    Ok(Code::Fine)
}

/// A scene on the device, with what its techniques and their judge need.
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

/// A scene from its truth camera and from the street; shimmer along a walk there.
fn measure(args: &BenchShadows, name: &str, specs: &[TechniqueSpec]) -> Result<Vec<Report>, Failure> {
    let truth = args.truth.join(format!("{name}.npz"));
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

/// What shadows of a very large scene cost.
fn cost(args: &BenchShadows) -> Result<Vec<Report>, Failure> {
    let specs = parse(&args.cost_shadow)?;
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

fn load(args: &BenchShadows, name: &str) -> Result<Scene, Failure> {
    let options = LoadOptions { color_textures: true, ..LoadOptions::default() };
    load_scene(&scene_file(&args.scenes, name)?, &options)
}

impl<'a, 's> Stage<'a, 's> {
    fn new(
        args: &'a BenchShadows,
        name: &'a str,
        scene: &'s Scene,
        truth: &'a TruthTracer<'s>,
        sun: Sun,
        specs: &[TechniqueSpec],
    ) -> Result<Self, Failure> {
        let gpu = Gpu::request(&args.device.gpu_options())?;
        let renderer = Renderer::new(gpu, scene, SceneOptions::default())?;
        let mut files = BakedFiles::default();
        let how = BakeOnTheWay {
            scene,
            sun,
            ignore_alpha: false,
            resolution: args.resolution,
            cube_resolution: args.cube_resolution,
            max_memory_bytes: None,
        };
        files.complete(specs, &how)?;
        let contenders = contenders(&renderer, specs, &files, JudgeArg::Technique)?;
        let (cache, key) = (args.cache.cache(&args.output), scene_key(scene, false));
        Ok(Self { args, name, renderer, truth, sun, files, cache, key, contenders })
    }

    fn report(&mut self, what: &str, camera: &Camera, path: Option<&CameraPath>) -> Result<Report, Failure> {
        let towards_sun = self.sun.towards();
        let (truth, cache, scene) = (self.truth, &self.cache, &self.key);
        let judge = Judge { truth, cache, scene, towards_sun, disc: DISC };
        let (renderer, contenders) = (&mut self.renderer, &mut self.contenders);
        let comparison = compare(renderer, &judge, camera, contenders, self.args.frames)?;
        let path = match path {
            Some(path) => Some(walk(renderer, &judge, path, PATH_SIZE, contenders)?),
            None => None,
        };
        for c in &comparison.compared {
            let row = &c.row;
            eprintln!("{}, {what}, {}: {} % wrong", self.name, row.name, percent(row.wrong(), 3));
        }
        Ok(Report {
            adapter: renderer.gpu().name(),
            software: renderer.gpu().is_software(),
            scene: self.name.to_owned(),
            camera: camera_figures(what, camera),
            sun: towards_sun,
            sun_angle_degrees: DISC.0,
            sun_samples: DISC.1,
            frames: self.args.frames,
            pixels: comparison.pixels,
            baked: self.files.figures(),
            left_out: renderer.gpu().left_out().into_iter().map(str::to_owned).collect(),
            techniques: comparison.compared.into_iter().map(|c| c.row).collect(),
            path,
        })
    }
}

/// Writes what there is so far.
fn write(args: &BenchShadows, reports: &[Report]) -> Result<(), Failure> {
    let mut text = String::from("# Shadows beside the truth\n\n");
    text.push_str(&summary(reports));
    for report in reports {
        text.push_str(&report.markdown().replacen("# ", "## ", 1).replace("\n## ", "\n### "));
        text.push('\n');
    }
    let document = serde_json::to_value(reports).map_err(|e| Failure::BadInput(e.to_string()))?;
    write_whole(&args.output.join("shadows.md"), text.as_bytes())?;
    write_whole(&args.output.join("shadows.json"), format!("{document:#}\n").as_bytes())
}

/// Wrong pixels of every technique by scene and camera.
fn summary(reports: &[Report]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for row in reports.iter().flat_map(|r| &r.techniques) {
        if !names.contains(&row.name.as_str()) {
            names.push(&row.name);
        }
    }
    let mut text = String::from(
        "Wrong pixels in % of those compared; in brackets, mean |shadow factor - truth|.\n\n| technique |",
    );
    for r in reports {
        // Writing to a String does not fail.
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
