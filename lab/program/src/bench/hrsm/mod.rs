//! `adumbra-lab bench hrsm`: hybrid-resolution shadow maps compared with plain ones, in the paper's tables
//! and figures.
//!
//! Source: Li, Yang, Zhao, Chen, *Hybrid-resolution Shadow Mapping Design and Hard Shadows Anti-aliasing in
//! Special Effects Movies*, Chinese Optics 9 (1), 2016, tables 1 and 2, figures 4 to 7. Additions: errors
//! against rays, and requirements with their outcome.

mod checks;
mod figures;
mod measure;
mod models;
mod tables;
mod why;

use adumbra::Sun;
use adumbra_program::exit::Code;
use adumbra_program::output::make_folder;
use adumbra_render::{Gpu, RenderError, Renderer, SceneOptions, Shot};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::figures::{Levels, Stage};
use self::measure::Group;
use self::measure::Measure;
pub(crate) use self::measure::Row;
use self::models::{MODELS, Model, SUN, WIRES};
use super::keep_sheet;
use crate::args::BenchHrsm;
use crate::results::{Check, Setup};
use adumbra_compare::compare::{Reference, camera_figures};
use adumbra_compare::report::{CameraFigures, PixelCounts};
use adumbra_compare::truth::{TruthTracer, scene_key};
use adumbra_compare::{Error, Result};

/// Side of the filter in texels: unfiltered, and PCF over 5 × 5 texels.
const FILTERS: [u32; 2] = [1, 5];

/// All results.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct HybridResults {
    /// How the pictures were drawn and timed.
    #[serde(flatten)]
    pub(crate) setup: Setup,
    /// Unit vector towards the sun.
    pub(crate) sun: [f64; 3],
    /// Texels per side of the finest levels that were measured.
    pub(crate) starts: Vec<u32>,
    /// The cases that the checks cover, and those that were not measured.
    pub(crate) covers: String,
    /// Requirements and their outcomes.
    pub(crate) checks: Vec<Check>,
    /// One entry per model.
    pub(crate) models: Vec<ModelFigures>,
    /// File and caption of each picture.
    pub(crate) sheets: Vec<[String; 2]>,
    /// Sheets, or parts of them, that exceed the device's limits, each with the reason.
    pub(crate) skipped: Vec<[String; 2]>,
}

/// One model's results.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct ModelFigures {
    /// Name.
    pub(crate) name: String,
    /// Title in tables.
    pub(crate) title: String,
    /// Whether the model is foliage.
    pub(crate) foliage: bool,
    /// Triangles without the ground.
    pub(crate) triangles: u64,
    /// The camera.
    pub(crate) camera: CameraFigures,
    /// Counts of compared and other pixels.
    pub(crate) pixels: PixelCounts,
    /// One entry per start and filter.
    pub(crate) groups: Vec<Group>,
    /// The paper's milliseconds with a shadow map and with a hybrid one, at 1024, 2048 and 4096.
    pub(crate) paper: [Option<[f64; 2]>; 3],
}

impl ModelFigures {
    pub(crate) fn group(&self, start: u32, filter: u32) -> Option<&Group> {
        self.groups.iter().find(|g| (g.start, g.filter) == (start, filter))
    }
}

pub(super) fn run(args: &BenchHrsm) -> Result<Code> {
    make_folder(&args.common.output)?;
    let asked = |model: &&Model| args.only.is_empty() || args.only.iter().any(|name| name == model.name);
    let [width, height] = args.common.size;
    let only = if args.only.is_empty() { String::new() } else { format!(" --only {}", args.only.join(",")) };
    let starts: Vec<String> = args.starts.iter().map(u32::to_string).collect();
    let command = format!(
        "adumbra-lab bench hrsm --scenes DIR --starts {} --size {width}x{height} --frames {}{only} -o DIR",
        starts.join(","),
        args.common.frames
    );
    let mut document = HybridResults {
        setup: Setup::new(command, args.common.frames, args.common.size),
        sun: Sun::from_direction(SUN)?.towards(),
        starts: args.starts.clone(),
        covers: String::new(),
        checks: Vec::new(),
        models: Vec::new(),
        sheets: Vec::new(),
        skipped: Vec::new(),
    };
    let mut levels = Levels::default();
    for model in MODELS.iter().chain([&WIRES]).filter(asked) {
        one(args, model, &mut document, &mut levels)?;
        write(args, &document)?;
    }
    if let Some((sheet, caption)) = levels.sheet() {
        keep_sheet(&args.common.output, &mut document.sheets, "hrsm-levels", caption, &sheet)?;
    }
    write(args, &document)?;
    super::say_tables(&args.common.output, "hrsm");
    Ok(Code::Fine)
}

/// Measures a model and draws its figures.
fn one(args: &BenchHrsm, model: &Model, document: &mut HybridResults, levels: &mut Levels) -> Result<()> {
    let standing = model.stand(&args.scenes)?;
    let truth = TruthTracer::build(&standing.scene, false);
    let gpu = Gpu::request(&args.common.device.gpu_options())?;
    document.setup.draw_on(&gpu);
    let mut renderer = Renderer::new(gpu, &standing.scene, SceneOptions::default())?;
    let (cache, key) = (args.common.cache.cache(&args.common.output), scene_key(&standing.scene, false));
    let towards_sun = document.sun;
    let reference = Reference { truth: &truth, cache: &cache, scene: &key, towards_sun, disc: (0.0, 1) };
    let camera = standing.whole(towards_sun, args.common.size);
    if model.name != WIRES.name {
        let shot = Shot { camera, towards_sun, number: 0 };
        let mut measure = Measure::new(&mut renderer, &reference, shot)?;
        let largest = args.starts.iter().copied().max();
        let mut groups = Vec::new();
        for (&start, filter) in args.starts.iter().flat_map(|s| FILTERS.map(|f| (s, f))) {
            adumbra_program::note!("{}, {start}, {filter} x {filter}:", model.title);
            groups.push(measure.group(start, filter, Some(start) == largest, args.common.frames)?);
        }
        document.models.push(ModelFigures {
            name: model.name.to_owned(),
            title: model.title.to_owned(),
            foliage: model.foliage,
            triangles: standing.triangles,
            camera: camera_figures(model.name, &camera),
            pixels: measure.pixels,
            groups,
            paper: model.paper,
        });
        document.setup.wall_time |= measure.wall_time;
        document.checks = checks::all(document);
        document.covers = checks::covers(document);
        // Saved now, because drawing the pictures may still fail.
        write(args, document)?;
    }
    let mut stage = Stage { renderer: &mut renderer, reference: &reference, standing: &standing };
    for (name, figure) in stage.figures(model.name) {
        if let Some((caption, sheet)) = fitting(figure, name.to_owned(), document)? {
            keep_sheet(&args.common.output, &mut document.sheets, name, caption, &sheet)?;
        }
    }
    if model.name != WIRES.name {
        let added = levels.add(&mut stage, model.title, args.starts.iter().copied().max().unwrap_or(1024));
        fitting(added, format!("hrsm-levels, {}", model.title), document)?;
    }
    Ok(())
}

/// Returns the result of drawing. If it exceeds the device's limits, returns `None` and records `what` as
/// skipped.
fn fitting<T>(drawn: Result<T>, what: String, document: &mut HybridResults) -> Result<Option<T>> {
    match drawn {
        Ok(drawn) => Ok(Some(drawn)),
        Err(Error::Render(why)) if matches!(*why, RenderError::TooLarge { .. }) => {
            document.skipped.push([what, why.to_string()]);
            Ok(None)
        }
        Err(other) => Err(other),
    }
}

/// Writes the results measured so far.
fn write(args: &BenchHrsm, document: &HybridResults) -> Result<()> {
    super::write(&args.common.output, "hrsm", &tables::markdown(document), document)
}
