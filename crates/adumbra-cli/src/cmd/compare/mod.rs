//! `adumbra compare`: techniques beside the truth, as tables and pictures.

mod output;

use std::path::Path;

use adumbra::camera::Camera;
use adumbra::light::Sun;
use adumbra::picture::BaseColors;
use adumbra::trace::Ray;
use adumbra_lab::camera_file::CameraFile;
use adumbra_lab::compare::{Comparison, Contender, Judge, camera_figures, compare, truth_for, walk};
use adumbra_lab::paths::CameraPath;
use adumbra_lab::report::{MOST_EXCLUDED, Report, TruthKind, figure, percent};
use adumbra_lab::truth::{StreetOptions, TruthTracer, scene_key, street_camera, truth_camera};
use adumbra_render::{Gpu, Renderer, SceneOptions, TechniqueSpec, build};

use super::baked::{BakeOnTheWay, BakedFiles};
use super::{load_scene, print_json, with_threads};
use crate::args::{Compare, DeviceArg, JudgeArg};
use crate::exit::{Code, Failure, Outcome};
use crate::output::{make_folder, note_input};

/// Frames of a path that is made.
const PATH_FRAMES: u32 = 60;

pub(crate) fn run(args: &Compare) -> Outcome {
    args.check()?;
    // A technique that shows a disc gets the one that judges it, unless it names its own.
    let disc = |spec: TechniqueSpec| Ok(spec.for_sun_angle(args.sun_angle)?);
    let specs = parse(&args.shadow)?.into_iter().map(disc).collect::<Result<Vec<_>, Failure>>()?;
    if args.device.device == DeviceArg::Cpu {
        return Err(Failure::Usage(
            "--device cpu: compare draws on a GPU adapter; a software one will do".to_owned(),
        ));
    }
    let files = BakedFiles::read(&args.baked.shadow_file)?;
    with_threads(args.work.threads, || draw(args, &specs, files))
}

/// Techniques, each asked for once.
pub(super) fn parse(names: &[String]) -> Result<Vec<TechniqueSpec>, Failure> {
    let specs: Vec<TechniqueSpec> = names.iter().map(|s| s.parse()).collect::<Result<_, _>>()?;
    for (i, spec) in specs.iter().enumerate() {
        if specs[..i].contains(spec) {
            return Err(Failure::Usage(format!("--shadow {spec}: it is asked for twice")));
        }
    }
    Ok(specs)
}

fn draw(args: &Compare, specs: &[TechniqueSpec], mut files: BakedFiles) -> Outcome {
    let mut load = args.load.load_options(args.work.max_memory)?;
    load.color_textures = true;
    load.ignore_alpha |= files.ignore_alpha();
    let scene = load_scene(&args.scene, &load)?;
    let truth = TruthTracer::build(&scene, load.ignore_alpha);
    let held = scene.memory_bytes() + truth.tracer().memory_bytes() + BaseColors::bytes_of(&scene);
    args.work.check_memory("the scene, its rays' trees and its mip levels", held)?;
    if files.sun().is_some() && args.sun.is_given() {
        return Err(Failure::Usage("--sun: the shadow file was baked for a sun of its own".to_owned()));
    }
    let from_file = args.camera.as_deref().map(camera_file).transpose()?.flatten();
    let sun = match (files.sun(), from_file.and_then(|f| f.sun)) {
        (Some(sun), _) => sun,
        (None, Some(sun)) if !args.sun.is_given() => sun,
        _ => args.sun.sun()?,
    };
    let (name, camera) = camera_of(args, &truth, sun, from_file.map(|f| f.camera))?;
    let gpu = Gpu::request(&args.device.gpu_options())?;
    let mut renderer = Renderer::new(gpu, &scene, SceneOptions { ignore_alpha: load.ignore_alpha })?;
    files.complete(
        specs,
        &BakeOnTheWay {
            scene: &scene,
            sun,
            ignore_alpha: load.ignore_alpha,
            resolution: args.baked.resolution,
            cube_resolution: args.baked.cube_resolution,
            max_memory_bytes: args.work.max_memory,
        },
    )?;
    make_folder(&args.output)?;
    let mut contenders = contenders(&renderer, specs, &files, args.judge)?;
    let (cache, key) = (args.cache.cache(&args.output), scene_key(&scene, load.ignore_alpha));
    let disc = (args.sun_angle, args.sun_samples);
    let judge = Judge { truth: &truth, cache: &cache, scene: &key, towards_sun: sun.towards(), disc };
    let comparison = compare(&mut renderer, &judge, &camera, &mut contenders, args.frames)?;
    let path = match &args.path {
        Some(path) => {
            let path = path_of(path, args.path_frames, &truth, &camera)?;
            Some(walk(&mut renderer, &judge, &path, args.view.size, &mut contenders)?)
        }
        None => None,
    };
    let report = Report {
        adapter: renderer.gpu().name(),
        software: renderer.gpu().is_software(),
        scene: args.scene.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned()),
        camera: camera_figures(&name, &camera),
        sun: sun.towards(),
        sun_angle_degrees: args.sun_angle,
        sun_samples: args.sun_samples,
        frames: args.frames,
        pixels: comparison.pixels,
        baked: files.figures(),
        left_out: renderer.gpu().left_out().into_iter().map(str::to_owned).collect(),
        techniques: comparison.compared.iter().map(|c| c.row.clone()).collect(),
        path,
    };
    finish(args, &report, &comparison)
}

fn finish(args: &Compare, report: &Report, comparison: &Comparison) -> Outcome {
    let document = serde_json::to_value(report).map_err(|e| Failure::BadInput(e.to_string()))?;
    output::write(&args.output, report, comparison, &document)?;
    for t in &report.techniques {
        t.notes.iter().for_each(|note| eprintln!("note: {}: {note}", t.name));
    }
    let excluded = report.pixels.excluded_share();
    let code = if args.strict && excluded > MOST_EXCLUDED { Code::CheckFailed } else { Code::Fine };
    if excluded > MOST_EXCLUDED {
        eprintln!(
            "warning: {} of the pixels with a surface are excluded, {:.1} %: GPU and rays see different surfaces there, and no figure counts them",
            report.pixels.excluded,
            100.0 * excluded
        );
    }
    if report.pixels.compared == 0 {
        eprintln!("warning: no pixel is compared, so there are no figures: no surface in view faces the sun");
    }
    if args.json {
        print_json(&document);
        return Ok(code);
    }
    say!("{}", args.output.join("report.md").display());
    for t in &report.techniques {
        let ms = t
            .gpu_ms
            .map_or_else(String::new, |ms| format!("{ms:9.3} ms{}", if t.wall_time { " wall" } else { "" }));
        say!(
            "  {:32} {ms} RMSE {}  FLIP {}  wrong lit {} %  wrong shadowed {} %",
            t.name,
            figure(t.rmse, 4),
            figure(t.flip, 4),
            percent(t.wrong_lit, 3),
            percent(t.wrong_shadowed, 3)
        );
    }
    Ok(code)
}

/// The camera of a file; none where the name is not a file's.
fn camera_file(name: &str) -> Result<Option<CameraFile>, Failure> {
    let path = Path::new(name);
    Ok(match path.extension().and_then(|e| e.to_str()) {
        Some("json") => {
            note_input("the camera itself", path);
            Some(CameraFile::read(path)?)
        }
        Some("npz") => {
            note_input("the truth file itself", path);
            let (camera, sun) = truth_camera(path)?;
            Some(CameraFile { camera, sun: Some(sun) })
        }
        _ => None,
    })
}

/// The camera, and what it is called.
fn camera_of(
    args: &Compare,
    truth: &TruthTracer<'_>,
    sun: Sun,
    from_file: Option<Camera>,
) -> Result<(String, Camera), Failure> {
    let [width, height] = args.view.size;
    let plain = args.view.camera(truth.bounds(), None)?;
    if let Some(camera) = from_file {
        let name = args.camera.as_deref().map(Path::new).and_then(Path::file_name);
        let name = name.map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        return Ok((name, Camera { width, height, ..camera }));
    }
    match args.camera.as_deref() {
        Some("street") => {
            let eye_height_world = args.eye_height;
            let options = StreetOptions { eye_height_world, fov_degrees: args.view.fov, width, height };
            Ok(("street".to_owned(), street_camera(truth, sun.towards(), &options)?))
        }
        Some("overview") => Ok(("overview".to_owned(), plain)),
        Some(other) => Err(Failure::Usage(format!(
            "--camera {other}: give street, overview, a camera (.json) that the viewer saved, or a truth file (.npz)"
        ))),
        None if args.view.eye.is_none() && args.view.target.is_none() => Ok(("overview".to_owned(), plain)),
        None => Ok(("given".to_owned(), plain)),
    }
}

fn path_of(
    path: &str,
    frames: Option<u32>,
    truth: &TruthTracer<'_>,
    camera: &Camera,
) -> Result<CameraPath, Failure> {
    let made = frames.unwrap_or(PATH_FRAMES);
    let diagonal = truth.bounds().diagonal();
    Ok(match path {
        "orbit" => CameraPath::orbit(truth.bounds(), made),
        "fly" => {
            // Not into what stands ahead.
            let forward = camera.view().forward;
            let direction = [forward[0], 0.0, forward[2]];
            let ray = Ray { origin: camera.eye, direction, t_min: 0.0, t_max: f64::INFINITY };
            let length = (direction[0].powi(2) + direction[2].powi(2)).sqrt();
            let free = truth.tracer().nearest_surface(&ray).map_or(f64::INFINITY, |hit| hit.t * length);
            CameraPath::fly(camera, (0.7 * free).min(0.15 * diagonal), 0.15 * diagonal, made)
        }
        file => {
            let file = Path::new(file);
            note_input("the camera path itself", file);
            let path = CameraPath::read(file)?;
            match frames {
                Some(frames) => path.with_frames(frames),
                None => path,
            }
        }
    })
}

pub(super) fn contenders(
    renderer: &Renderer,
    specs: &[TechniqueSpec],
    files: &BakedFiles,
    judge: JudgeArg,
) -> Result<Vec<Contender>, Failure> {
    let contender = |spec: &TechniqueSpec| {
        let prepared = if spec.name() == "truth" {
            spec.reader().finish()?;
            None
        } else {
            Some(renderer.prepare(build(renderer.gpu(), spec, files.baked())?)?)
        };
        let truth = match judge {
            JudgeArg::Technique => truth_for(spec),
            JudgeArg::Hard => TruthKind::Hard,
            JudgeArg::Disc => TruthKind::Disc,
        };
        Ok(Contender { spec: spec.clone(), prepared, truth })
    };
    specs.iter().map(contender).collect()
}
