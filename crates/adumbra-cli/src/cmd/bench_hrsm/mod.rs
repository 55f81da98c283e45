//! `adumbra bench hrsm`: hybrid-resolution shadow maps beside plain ones, in the paper's tables and figures.
//!
//! Source: Li, Yang, Zhao, Chen, *Hybrid-resolution Shadow Mapping Design and Hard Shadows Anti-aliasing in Special Effects Movies*,
//! Chinese Optics 9 (1), 2016, tables 1 and 2, figures 4 to 7. Departures: errors against rays, and requirements with their outcome.

mod checks;
mod figures;
mod measure;
mod models;
mod tables;
mod why;

use adumbra::light::Sun;
use adumbra::picture::Picture;
use adumbra_lab::compare::{Judge, camera_figures};
use adumbra_lab::pictures::png;
use adumbra_lab::report::{CameraFigures, PixelCounts};
use adumbra_lab::truth::{TruthTracer, scene_key};
use adumbra_render::{Gpu, RenderError, Renderer, SceneOptions, Shot};
use serde::Serialize;

use self::checks::Check;
use self::figures::{Levels, Stage};
use self::measure::{Group, Measure};
use self::models::{MODELS, Model, SUN, WIRES};
use crate::args::BenchHrsm;
use crate::exit::{Code, Failure, Outcome};
use crate::output::{make_folder, write_whole};

/// Unfiltered, and PCF over 5 × 5 texels.
const FILTERS: [u32; 2] = [1, 5];

/// All figures.
#[derive(Serialize)]
struct Document {
    command: String,
    adapter: String,
    /// The adapter is a program.
    software: bool,
    /// Times are wall times: the device has no timestamps, or is a program.
    wall_time: bool,
    frames: u32,
    size: [u32; 2],
    sun: [f64; 3],
    starts: Vec<u32>,
    /// What the checks speak for, and what was not measured.
    covers: String,
    checks: Vec<Check>,
    models: Vec<ModelFigures>,
    /// File and caption of each picture.
    sheets: Vec<[String; 2]>,
    /// Sheet, or part of one, that is larger than the device takes, and why.
    left_out: Vec<[String; 2]>,
}

/// One model's figures.
#[derive(Serialize)]
struct ModelFigures {
    name: &'static str,
    title: &'static str,
    foliage: bool,
    /// Without the ground.
    triangles: u64,
    camera: CameraFigures,
    pixels: PixelCounts,
    groups: Vec<Group>,
    /// The paper's milliseconds with a shadow map and with a hybrid one, at 1024, 2048 and 4096.
    paper: [Option<[f64; 2]>; 3],
}

impl ModelFigures {
    fn group(&self, start: u32, filter: u32) -> Option<&Group> {
        self.groups.iter().find(|g| (g.start, g.filter) == (start, filter))
    }
}

pub(super) fn run(args: &BenchHrsm) -> Outcome {
    make_folder(&args.output)?;
    let asked = |model: &&Model| args.only.is_empty() || args.only.iter().any(|name| name == model.name);
    let [width, height] = args.size;
    let only = if args.only.is_empty() { String::new() } else { format!(" --only {}", args.only.join(",")) };
    let starts: Vec<String> = args.starts.iter().map(u32::to_string).collect();
    let mut document = Document {
        command: format!(
            "adumbra bench hrsm --scenes DIR --starts {} --size {width}x{height} --frames {}{only} -o DIR",
            starts.join(","),
            args.frames
        ),
        adapter: String::new(),
        software: false,
        wall_time: false,
        frames: args.frames,
        size: args.size,
        sun: Sun::from_direction(SUN)?.towards(),
        starts: args.starts.clone(),
        covers: String::new(),
        checks: Vec::new(),
        models: Vec::new(),
        sheets: Vec::new(),
        left_out: Vec::new(),
    };
    let mut levels = Levels::default();
    for model in MODELS.iter().chain([&WIRES]).filter(asked) {
        one(args, model, &mut document, &mut levels)?;
        write(args, &document)?;
    }
    if let Some((sheet, caption)) = levels.sheet() {
        keep(args, &mut document, "hrsm-levels", caption, &sheet)?;
    }
    write(args, &document)?;
    say!("{}", args.output.join("hrsm.md").display());
    Ok(Code::Fine)
}

/// Measures a model and draws its figures.
fn one(args: &BenchHrsm, model: &Model, document: &mut Document, levels: &mut Levels) -> Result<(), Failure> {
    let standing = model.stand(&args.scenes)?;
    let truth = TruthTracer::build(&standing.scene, false);
    let gpu = Gpu::request(&args.device.gpu_options())?;
    document.adapter = gpu.name();
    document.software = gpu.is_software();
    let mut renderer = Renderer::new(gpu, &standing.scene, SceneOptions::default())?;
    let (cache, key) = (args.cache.cache(&args.output), scene_key(&standing.scene, false));
    let towards_sun = document.sun;
    let judge = Judge { truth: &truth, cache: &cache, scene: &key, towards_sun, disc: (0.0, 1) };
    let camera = standing.whole(towards_sun, args.size);
    if model.name != WIRES.name {
        let shot = Shot { camera, towards_sun, number: 0 };
        let mut measure = Measure::new(&mut renderer, &judge, shot)?;
        let largest = args.starts.iter().copied().max();
        let mut groups = Vec::new();
        for (&start, filter) in args.starts.iter().flat_map(|s| FILTERS.map(|f| (s, f))) {
            eprintln!("{}, {start}, {filter} x {filter}:", model.title);
            groups.push(measure.group(start, filter, Some(start) == largest, args.frames)?);
        }
        document.models.push(ModelFigures {
            name: model.name,
            title: model.title,
            foliage: model.foliage,
            triangles: standing.triangles,
            camera: camera_figures(model.name, &camera),
            pixels: measure.pixels,
            groups,
            paper: model.paper,
        });
        document.wall_time |= measure.wall_time;
        document.checks = checks::all(document);
        document.covers = checks::covers(document);
        // Pictures may fail where figures did not.
        write(args, document)?;
    }
    let mut stage = Stage { renderer: &mut renderer, judge: &judge, standing: &standing };
    for (name, figure) in stage.figures(model.name) {
        if let Some((caption, sheet)) = fitting(figure, name.to_owned(), document)? {
            keep(args, document, name, caption, &sheet)?;
        }
    }
    if model.name != WIRES.name {
        let added = levels.add(&mut stage, model.title, args.starts.iter().copied().max().unwrap_or(1024));
        fitting(added, format!("hrsm-levels, {}", model.title), document)?;
    }
    Ok(())
}

/// What was drawn; where it is larger than the device takes, notes `what` as left out.
fn fitting<T>(
    drawn: Result<T, Failure>,
    what: String,
    document: &mut Document,
) -> Result<Option<T>, Failure> {
    match drawn {
        Ok(drawn) => Ok(Some(drawn)),
        Err(Failure::Render(why @ RenderError::TooLarge { .. })) => {
            document.left_out.push([what, why.to_string()]);
            Ok(None)
        }
        Err(other) => Err(other),
    }
}

fn keep(
    args: &BenchHrsm,
    document: &mut Document,
    name: &str,
    caption: String,
    sheet: &Picture,
) -> Result<(), Failure> {
    let file = format!("{name}.png");
    write_whole(&args.output.join(&file), &png(sheet)?)?;
    document.sheets.push([file, caption]);
    Ok(())
}

/// Writes what there is so far.
fn write(args: &BenchHrsm, document: &Document) -> Result<(), Failure> {
    write_whole(&args.output.join("hrsm.md"), tables::markdown(document).as_bytes())?;
    let json = serde_json::to_value(document).map_err(|e| Failure::BadInput(e.to_string()))?;
    write_whole(&args.output.join("hrsm.json"), format!("{json:#}\n").as_bytes())
}
