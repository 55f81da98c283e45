//! The verb `compare`: compares techniques with ray-traced truth, as tables and pictures.

mod args;
mod output;

use std::path::Path;

use crate::Result;
use crate::args::DeviceArg;
use crate::baked::{BakeOnDemand, BakedFiles};
use crate::camera_file::CameraFile;
use crate::compare::{Comparison, Reference, camera_figures, compare, sweep, walk};
use crate::contenders::{contenders, parse};
use crate::paths::CameraPath;
use crate::report::{MAX_EXCLUDED, Report};
use crate::swept::SweptSun;
use crate::truth::{StreetOptions, TruthTracer, scene_key, street_camera, truth_camera};
use crate::verbs::Offer;
use adumbra::Sun;
use adumbra_program::exit::{Code, Failure};
use adumbra_program::format::{figure, percent};
use adumbra_program::output::{make_folder, note_input, print_json};
use adumbra_program::say;
use adumbra_program::scene::load_scene_within;
use adumbra_program::sun::{ChosenSun, SunSource};
use adumbra_program::threads::with_threads;
use adumbra_render::{Gpu, Renderer, SceneOptions, TechniqueSpec};
use adumbra_scene::Camera;
use adumbra_solar::Day;
use adumbra_truth::picture::{BaseColors, Picture};
use adumbra_truth::trace::Ray;

pub use args::{Compare, PATH_FRAMES};

/// Runs the verb.
///
/// # Errors
///
/// Returns an error for wrong arguments, inputs that cannot be read, and a device that fails.
pub fn run(args: &Compare, offer: Offer<'_>) -> Result<Code> {
    args.check()?;
    // Reject an invalid sun before loading the scene.
    args.sun.given_for(&args.scene, &args.load)?;
    // A technique that takes the sun's angular diameter gets that of the disc that it is compared with,
    // unless it names its own.
    let specs: Vec<TechniqueSpec> = parse(offer.techniques, &args.shadow)?
        .iter()
        .map(|spec| spec.with_sun_degrees(args.sun_degrees))
        .collect();
    if args.device.device == DeviceArg::Cpu {
        return Err(Failure::Usage(
            "--device cpu: compare needs a GPU adapter; a software adapter is enough".to_owned(),
        )
        .into());
    }
    let swept = args.sun_sweep.as_ref().map(|day| swept_sun(args, day.as_ref())).transpose()?;
    let more = (offer.more_files)();
    let files = match swept {
        Some(_) => BakedFiles::with(more),
        None => BakedFiles::read(&args.shadow_file, args.run.memory_limit(), more)?,
    };
    with_threads(args.run.threads, || draw(args, &specs, files, swept))?
}

/// Returns the sun of a sweep across a day, or across a sun path.
fn swept_sun(args: &Compare, day: Option<&Day>) -> Result<SweptSun> {
    let usage = |text: &str| Err(Failure::Usage(text.to_owned()).into());
    match (args.shadow_file.as_slice(), day) {
        ([], None) => usage(
            "--sun-sweep: give a day, such as lat=48,lon=11,date=2026-06-21,from=7,to=19, or a sun path with --shadow-file",
        ),
        ([], Some(day)) => SweptSun::of_day(day, args.sweep_steps),
        ([file], day) => SweptSun::of_file(file, day, args.sweep_steps, args.run.memory_limit()),
        _ => usage("--shadow-file: --sun-sweep takes one, a sun path"),
    }
}

fn draw(
    args: &Compare,
    specs: &[TechniqueSpec],
    mut files: BakedFiles,
    mut swept: Option<SweptSun>,
) -> Result<Code> {
    let mut load = args.load.load_options()?;
    load.color_textures = true;
    for scene in [files.scene(), swept.as_ref().and_then(SweptSun::scene)].into_iter().flatten() {
        load.follow(scene, &args.scene);
    }
    let scene = load_scene_within(args.run.memory_limit(), &args.scene, &load)?;
    let truth = TruthTracer::build(&scene, load.ignore_alpha);
    let held = scene.memory_bytes() + truth.tracer().memory_bytes() + BaseColors::bytes_of(&scene);
    args.run.check_memory("the scene, its acceleration structure and its mip levels", held, held)?;
    if files.sun().is_some() && args.sun.is_given() {
        return Err(Failure::Usage(
            "--sun: the shadow file determines the sun; remove the option".to_owned(),
        )
        .into());
    }
    let from_file = args.camera.as_deref().map(camera_file).transpose()?.flatten();
    let of_sweep = swept.as_ref().map(|swept| Sun::from_direction(swept.middle().1)).transpose()?;
    let chosen = match (of_sweep.or(files.sun()), from_file.and_then(|f| f.sun)) {
        (Some(sun), _) if swept.is_some() => ChosenSun::from_source(sun, SunSource::SunSweep),
        (Some(sun), _) => ChosenSun::from_source(sun, SunSource::ShadowFile),
        (None, Some(sun)) if !args.sun.is_given() => ChosenSun::from_source(sun, SunSource::CameraFile),
        _ => args.sun.choose(&scene, &args.scene)?,
    };
    let sun = chosen.sun;
    let (name, camera) = camera_of(args, &truth, sun, from_file.map(|f| f.camera))?;
    let gpu = Gpu::request(&args.device.gpu_options())?;
    let mut renderer = Renderer::new(gpu, &scene, SceneOptions { ignore_alpha: load.ignore_alpha })?;
    let how = BakeOnDemand {
        scene: &scene,
        sun,
        ignore_alpha: load.ignore_alpha,
        resolution: args.resolutions.resolution,
        max_memory_bytes: args.run.memory_limit().share(held).bytes(),
    };
    match &mut swept {
        Some(swept) => swept.complete(specs, &how)?,
        None => files.complete(specs, &how)?,
    }
    make_folder(&args.output)?;
    let baked = swept.as_ref().map_or_else(|| files.baked(), SweptSun::baked);
    let mut contenders = contenders(&renderer, specs, baked, args.reference)?;
    let (cache, key) = (args.cache.cache(&args.output), scene_key(&scene, load.ignore_alpha));
    let disc = (args.sun_degrees, args.sun_samples);
    let reference = Reference { truth: &truth, cache: &cache, scene: &key, towards_sun: sun.towards(), disc };
    let comparison = compare(&mut renderer, &reference, &camera, &mut contenders, args.frames)?;
    let path = match &args.path {
        Some(path) => {
            let path = path_of(path, args.path_frames, &truth, &camera)?;
            Some(walk(&mut renderer, &reference, &path, args.view.size, &mut contenders)?)
        }
        None => None,
    };
    let swept = match &mut swept {
        Some(sun) => Some(sweep(&mut renderer, &reference, &camera, sun, &mut contenders)?),
        None => None,
    };
    let report = Report {
        adapter: renderer.gpu().name(),
        software: renderer.gpu().is_software(),
        scene: args.scene.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned()),
        camera: camera_figures(&name, &camera),
        sun: sun.towards(),
        sun_origin: Some(chosen.origin.clone()),
        sun_degrees: args.sun_degrees,
        sun_samples: args.sun_samples,
        frames: args.frames,
        pixels: comparison.pixels,
        baked: files.figures(),
        missing_features: renderer.gpu().missing_features().into_iter().map(str::to_owned).collect(),
        techniques: comparison.compared.iter().map(|c| c.row.clone()).collect(),
        path,
        sweep: swept.as_ref().map(|swept| swept.report.clone()),
    };
    let of_changes = swept.map_or_else(Vec::new, |swept| swept.pictures);
    finish(args, &report, &comparison, &of_changes, &chosen)
}

fn finish(
    args: &Compare,
    report: &Report,
    comparison: &Comparison,
    of_changes: &[Picture],
    sun: &ChosenSun,
) -> Result<Code> {
    let document = serde_json::to_value(report).map_err(|e| Failure::BadInput(e.to_string()))?;
    output::write(&args.output, report, comparison, of_changes, &document)?;
    for t in &report.techniques {
        t.notes.iter().for_each(|note| adumbra_program::note!("note: {}: {note}", t.name));
    }
    let excluded = report.pixels.excluded_share();
    let code = if args.check_surfaces && excluded > MAX_EXCLUDED { Code::CheckFailed } else { Code::Fine };
    if excluded > MAX_EXCLUDED {
        adumbra_program::note!(
            "warning: {} of the pixels with a surface are excluded ({:.1} %): GPU and rays see different surfaces there, and no figure counts them",
            report.pixels.excluded,
            100.0 * excluded
        );
    }
    if report.pixels.compared == 0 {
        adumbra_program::note!(
            "warning: no pixels were compared because no surface in view faces the sun; there are no figures"
        );
    }
    if args.run.json {
        print_json(&document)?;
        return Ok(code);
    }
    say!("{}", args.output.join("report.md").display());
    say!("  {sun}");
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
    if let Some(sweep) = &report.sweep {
        let rays = percent(sweep.rays_changes, 4);
        say!(
            "  while the sun moves, {} steps; with rays {rays} % of the pixels change per step",
            sweep.steps
        );
        for t in &sweep.techniques {
            say!(
                "  {:32} wrong {} %  worst {} %  changes {} %  in excess {} %",
                t.name,
                percent(t.wrong, 3),
                percent(t.worst_wrong, 3),
                percent(t.changes, 4),
                percent(t.excess, 4)
            );
        }
    }
    Ok(code)
}

/// Reads the camera of a file. `None` if the name is not a file's.
fn camera_file(name: &str) -> Result<Option<CameraFile>> {
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

/// Returns the camera and its name.
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
            "--camera {other}: give street, overview, a camera (.json) saved by the viewer, or a truth file (.npz)"
        ))),
        None if args.view.eye.is_none() && args.view.target.is_none() => Ok(("overview".to_owned(), plain)),
        None => Ok(("given".to_owned(), plain)),
    }
}

fn path_of(path: &str, frames: Option<u32>, truth: &TruthTracer<'_>, camera: &Camera) -> Result<CameraPath> {
    let made = frames.unwrap_or(PATH_FRAMES);
    let diagonal = truth.bounds().diagonal();
    Ok(match path {
        "orbit" => CameraPath::orbit(truth.bounds(), made),
        "fly" => {
            // Stop before the nearest surface ahead.
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
