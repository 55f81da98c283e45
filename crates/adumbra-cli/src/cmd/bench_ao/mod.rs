//! `adumbra bench ao`: every estimator of ambient occlusion beside rays, each scene with the settings of the half
//! that lacks it.
//!
//! Source of the claims, figures and times: Qiu, Li, Wu, Shi, Zhang, *Improved Screen Space Ambient Occlusion*,
//! Chinese Journal of Computers 37(3), 2014. Departures: RMSE and the rest against rays, flicker, `gtao`, and
//! requirements with their outcome.

mod checks;
mod claims;
mod measure;
mod peers;
mod sheets;
mod sweep;
mod tables;
mod variants;

use adumbra::picture::Picture;
use adumbra_lab::compare::camera_figures;
use adumbra_lab::occlusion::{
    Flicker, Fold, Judged, OcclusionErrors, OcclusionJudge, OcclusionScene, OcclusionStage, OcclusionView,
    Record, SCENES, TunedOn, truth_flicker, with_tuned,
};
use adumbra_lab::peers::occlusion::OcclusionRow;
use adumbra_lab::pictures::png;
use adumbra_lab::report::{CameraFigures, PixelCounts};
use adumbra_lab::truth::{TruthTracer, scene_key};
use adumbra_render::occlusion::{Estimator, OcclusionSettings};
use adumbra_render::{Gpu, SceneOptions};
use serde::Serialize;

use self::checks::Check;
use self::measure::Row;
use self::sweep::{EqualTime, Point};
use self::variants::Variant;
use crate::args::BenchAo;
use crate::exit::{Code, Failure, Outcome};
use crate::output::{make_folder, write_whole};

/// Frames of the path that the truth's own flicker is measured over.
const FLOOR_FRAMES: usize = 3;
/// Every such pixel is traced twice for the truth's standard error.
const ERROR_STEP: usize = 37;

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
    /// Pixels of the path's pictures.
    path_size: [u32; 2],
    rays: u32,
    samples: u32,
    /// Estimators with their defaults, because the record holds none of their parameters.
    untuned: Vec<&'static str>,
    checks: Vec<Check>,
    scenes: Vec<SceneFigures>,
    /// Beside today's engines; none where no truth files were given.
    peers: Option<Vec<OcclusionRow>>,
    /// File and caption of each picture.
    sheets: Vec<[String; 2]>,
    /// What this build has not, and why.
    left_out: Vec<[String; 2]>,
}

/// One scene's figures.
#[derive(Serialize)]
struct SceneFigures {
    name: &'static str,
    title: &'static str,
    fold: Fold,
    /// What its settings were tuned on.
    tuned_on: TunedOn,
    radius_world: f64,
    camera: CameraFigures,
    pixels: PixelCounts,
    /// Of the truth, measured with other rays; and the bound of independent ones.
    standard_error: Option<f64>,
    standard_error_bound: f64,
    /// Open sky everywhere.
    none: OcclusionErrors,
    /// The truth's own, over the path's first frames.
    truth_flicker: Option<Flicker>,
    /// Shares of the compared pixels: on edges, and flat.
    edge_share: f64,
    flat_share: f64,
    rows: Vec<Row>,
    variants: Vec<Variant>,
    sweep: Vec<Point>,
    equal_time: Option<EqualTime>,
}

impl SceneFigures {
    fn row(&self, estimator: Estimator) -> Option<&Row> {
        self.rows.iter().find(|r| r.estimator == estimator.name())
    }

    fn variant(&self, options: &str) -> Option<&Variant> {
        self.variants.iter().find(|v| v.options == options)
    }
}

/// A scene on a device with its truth, and what it is measured with.
struct Bench<'a, 'j, 's> {
    args: &'a BenchAo,
    judge: OcclusionJudge<'j, 's>,
    judged: &'a Judged,
    stage: &'a mut OcclusionStage,
    on: TunedOn,
    wall_time: bool,
}

impl Bench<'_, '_, '_> {
    /// An estimator as it is judged here.
    fn settings(&self, estimator: Estimator) -> OcclusionSettings {
        with_tuned(OcclusionSettings::new(estimator, self.judge.radius_world), self.on)
    }
}

pub(super) fn run(args: &BenchAo) -> Outcome {
    make_folder(&args.output)?;
    let mut document = Document::new(args);
    let asked = |scene: &&OcclusionScene| args.only.is_empty() || args.only.iter().any(|n| n == scene.name);
    for scene in SCENES.iter().filter(asked) {
        eprintln!("{}:", scene.title);
        one(args, scene, &mut document)?;
        write(args, &mut document)?;
    }
    if let Some(truth) = &args.truth {
        document.peers = Some(peers::rows(args, truth)?);
    }
    write(args, &mut document)?;
    say!("{}", args.output.join("ao.md").display());
    Ok(Code::Fine)
}

impl Document {
    fn new(args: &BenchAo) -> Self {
        let [width, height] = args.size;
        let only =
            if args.only.is_empty() { String::new() } else { format!(" --only {}", args.only.join(",")) };
        let truth = if args.truth.is_some() { " --truth DIR" } else { "" };
        let unknown = |e: &Estimator| {
            let varies = e.parameters().iter().any(|p| p.search.is_some());
            varies && TunedOn::ALL.iter().any(|on| Record::embedded().shape(*e, *on).is_none())
        };
        Self {
            command: format!(
                "adumbra bench ao --scenes DIR{truth} --size {width}x{height} --frames {} --rays {}{only} -o DIR",
                args.frames, args.rays
            ),
            adapter: String::new(),
            software: false,
            wall_time: false,
            frames: args.frames,
            size: args.size,
            path_size: path_size(args),
            rays: args.rays,
            samples: OcclusionSettings::new(Estimator::Issao, 1.0).samples,
            untuned: Estimator::ALL.iter().filter(|e| unknown(e)).map(|e| e.name()).collect(),
            checks: Vec::new(),
            scenes: Vec::new(),
            peers: None,
            sheets: Vec::new(),
            left_out: Vec::new(),
        }
    }
}

/// Half of the still pictures' width and height.
fn path_size(args: &BenchAo) -> [u32; 2] {
    args.size.map(|s| s.div_ceil(2))
}

/// Measures a scene and draws its sheets.
fn one(args: &BenchAo, scene: &OcclusionScene, document: &mut Document) -> Result<(), Failure> {
    let view: OcclusionView = scene.open(&args.scenes)?;
    let truth = TruthTracer::build(&view.scene, false);
    let (cache, key) = (args.cache.cache(&args.output), scene_key(&view.scene, false));
    let gpu = Gpu::request(&args.device.gpu_options())?;
    document.adapter = gpu.name();
    document.software = gpu.is_software();
    let camera = view.camera(args.size);
    let mut stage = OcclusionStage::new(gpu, &view.scene, SceneOptions::default(), camera)?;
    let radius_world = view.radius_world;
    let judge = OcclusionJudge { truth: &truth, cache: &cache, scene: &key, radius_world, rays: args.rays };
    let judged = judge.judge(&stage)?;
    let path = view.path(path_size(args));
    let probe = adumbra_lab::occlusion::ClaimProbe::new(&judged, radius_world);
    let [edge_share, flat_share] = probe.shares();
    let mut figures = SceneFigures {
        name: scene.name,
        title: scene.title,
        fold: scene.fold,
        tuned_on: TunedOn::without(scene.name),
        radius_world,
        camera: camera_figures(scene.name, &camera),
        pixels: judged.pixels,
        standard_error: truth.measured_error(
            &judged.surfaces,
            &judged.truth,
            radius_world,
            args.rays,
            ERROR_STEP,
        ),
        standard_error_bound: judged.error_bound(args.rays),
        none: judged.errors_of_none(),
        truth_flicker: truth_flicker(&judge, &path[..FLOOR_FRAMES])?,
        edge_share,
        flat_share,
        rows: Vec::new(),
        variants: Vec::new(),
        sweep: Vec::new(),
        equal_time: None,
    };
    let on = figures.tuned_on;
    let mut bench = Bench { args, judge, judged: &judged, stage: &mut stage, on, wall_time: false };
    let mut pictures = Vec::new();
    figures.rows = bench.rows(&probe, &mut pictures)?;
    figures.variants = bench.variants(&probe, &mut pictures, &mut document.left_out)?;
    figures.sweep = bench.sweep()?;
    figures.equal_time = bench.equal_time(&figures.sweep)?;
    bench.flicker(&path, &mut figures)?;
    document.wall_time |= bench.wall_time;
    document.scenes.push(figures);
    // Pictures may fail where figures did not.
    write(args, document)?;
    let Some(figures) = document.scenes.last() else { return Ok(()) };
    for (name, caption, sheet) in sheets::all(figures, &judged, &pictures)? {
        keep(args, &mut document.sheets, &name, caption, &sheet)?;
    }
    Ok(())
}

fn keep(
    args: &BenchAo,
    sheets: &mut Vec<[String; 2]>,
    name: &str,
    caption: String,
    sheet: &Picture,
) -> Result<(), Failure> {
    let file = format!("{name}.png");
    write_whole(&args.output.join(&file), &png(sheet)?)?;
    sheets.push([file, caption]);
    Ok(())
}

/// Writes what there is so far.
fn write(args: &BenchAo, document: &mut Document) -> Result<(), Failure> {
    document.checks = checks::all(document);
    if !document.scenes.is_empty() {
        sweep::plot(&args.output.join("ao-time.svg"), document)?;
    }
    write_whole(&args.output.join("ao.md"), tables::markdown(document).as_bytes())?;
    let json = serde_json::to_value(&*document).map_err(|e| Failure::BadInput(e.to_string()))?;
    write_whole(&args.output.join("ao.json"), format!("{json:#}\n").as_bytes())
}
