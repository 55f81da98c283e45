//! `adumbra-lab bench ao`: every estimator of ambient occlusion compared with rays.
//!
//! The settings used on a scene were tuned on the half of the scenes that excludes it.
//!
//! Source of the claims, figures and times: Qiu, Li, Wu, Shi, Zhang, *Improved Screen Space Ambient
//! Occlusion*, Chinese Journal of Computers 37(3), 2014. Additions: RMSE and the other metrics against rays,
//! flicker, `gtao`, and requirements with their outcome.

mod checks;
mod claims;
mod measure;
mod peers;
mod sheets;
mod sweep;
mod tables;
mod variants;

use adumbra_program::exit::Code;
use adumbra_program::output::make_folder;
use adumbra_render::occlusion::{Estimator, OcclusionSettings};
use adumbra_render::{Gpu, SceneOptions};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

pub(crate) use self::measure::Row;
use self::sweep::{EqualTime, Point};
pub(crate) use self::variants::Variant;
use super::keep_sheet;
use crate::args::BenchAo;
use crate::occlusion::{
    Flicker, Fold, OcclusionErrors, OcclusionReference, OcclusionScene, OcclusionStage, OcclusionView,
    Record, SCENES, TracedView, TunedOn, truth_flicker, with_tuned,
};
use crate::peers::occlusion::OcclusionRow;
use crate::results::{Check, Setup};
use adumbra_compare::Result;
use adumbra_compare::compare::camera_figures;
use adumbra_compare::report::{CameraFigures, PixelCounts};
use adumbra_compare::truth::{TruthTracer, scene_key};

/// Number of the path's frames over which the truth's own flicker is measured.
const FLOOR_FRAMES: usize = 3;
/// One pixel in this many is traced a second time to measure the truth's standard error.
const ERROR_STEP: usize = 37;

/// All results.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct AoResults {
    /// How the pictures were drawn and timed.
    #[serde(flatten)]
    pub(crate) setup: Setup,
    /// Size of the path's pictures in pixels.
    pub(crate) path_size: [u32; 2],
    /// Rays per pixel of the truth.
    pub(crate) rays: u32,
    /// Taps per pixel.
    pub(crate) samples: u32,
    /// Estimators run with their defaults, because the record lacks parameters for them.
    pub(crate) untuned: Vec<Cow<'static, str>>,
    /// Requirements and their outcomes.
    pub(crate) checks: Vec<Check>,
    /// One entry per scene.
    pub(crate) scenes: Vec<SceneFigures>,
    /// Comparison with current engines; `None` if no truth files were given.
    pub(crate) peers: Option<Vec<OcclusionRow>>,
    /// File and caption of each picture.
    pub(crate) sheets: Vec<[String; 2]>,
    /// Variants that this build does not support, each with the reason.
    pub(crate) skipped: Vec<[String; 2]>,
}

/// One scene's results.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct SceneFigures {
    /// Name.
    pub(crate) name: Cow<'static, str>,
    /// Title in tables.
    pub(crate) title: Cow<'static, str>,
    /// Half of the scenes that it belongs to.
    pub(crate) fold: Fold,
    /// The scenes that its settings were tuned on.
    pub(crate) tuned_on: TunedOn,
    /// Radius of the occlusion in world units.
    pub(crate) radius_world: f64,
    /// The camera.
    pub(crate) camera: CameraFigures,
    /// Counts of compared and other pixels.
    pub(crate) pixels: PixelCounts,
    /// Standard error of the truth, measured with a second set of rays.
    pub(crate) standard_error: Option<f64>,
    /// Upper bound on that error, as for independent rays.
    pub(crate) standard_error_bound: f64,
    /// Errors of open sky everywhere.
    pub(crate) none: OcclusionErrors,
    /// The truth's own flicker, over the path's first frames.
    pub(crate) truth_flicker: Option<Flicker>,
    /// Share of the compared pixels that are on edges.
    pub(crate) edge_share: f64,
    /// Share of the compared pixels where the truth is flat.
    pub(crate) flat_share: f64,
    /// One row per measurement.
    pub(crate) rows: Vec<Row>,
    /// Variants of issao.
    pub(crate) variants: Vec<Variant>,
    /// Error over time, by number of taps.
    pub(crate) sweep: Vec<Point>,
    /// Issao with as many taps as the time of gtao allows; `None` if that was not measured.
    pub(crate) equal_time: Option<EqualTime>,
}

impl SceneFigures {
    fn row(&self, estimator: Estimator) -> Option<&Row> {
        self.rows.iter().find(|r| r.estimator == estimator.name())
    }

    pub(crate) fn variant(&self, options: &str) -> Option<&Variant> {
        self.variants.iter().find(|v| v.options == options)
    }
}

/// A scene on a device with its truth and the settings that it is measured with.
struct Bench<'a, 'j, 's> {
    args: &'a BenchAo,
    reference: OcclusionReference<'j, 's>,
    traced_view: &'a TracedView,
    stage: &'a mut OcclusionStage,
    on: TunedOn,
    wall_time: bool,
}

impl Bench<'_, '_, '_> {
    /// Returns the settings with which an estimator is measured here.
    fn settings(&self, estimator: Estimator) -> OcclusionSettings {
        with_tuned(OcclusionSettings::new(estimator, self.reference.radius_world), self.on)
    }
}

pub(super) fn run(args: &BenchAo) -> Result<Code> {
    make_folder(&args.common.output)?;
    let mut document = AoResults::new(args);
    let asked = |scene: &&OcclusionScene| args.only.is_empty() || args.only.iter().any(|n| n == scene.name);
    for scene in SCENES.iter().filter(asked) {
        adumbra_program::note!("{}:", scene.title);
        one(args, scene, &mut document)?;
        write(args, &mut document)?;
    }
    if let Some(truth) = &args.truth {
        document.peers = Some(peers::rows(args, truth)?);
    }
    write(args, &mut document)?;
    super::say_tables(&args.common.output, "ao");
    Ok(Code::Fine)
}

impl AoResults {
    fn new(args: &BenchAo) -> Self {
        let [width, height] = args.common.size;
        let only =
            if args.only.is_empty() { String::new() } else { format!(" --only {}", args.only.join(",")) };
        let truth = if args.truth.is_some() { " --truth DIR" } else { "" };
        let unknown = |e: &Estimator| {
            let varies = e.parameters().iter().any(|p| p.search.is_some());
            varies && TunedOn::ALL.iter().any(|on| Record::embedded().shape(*e, *on).is_none())
        };
        let command = format!(
            "adumbra-lab bench ao --scenes DIR{truth} --size {width}x{height} --frames {} --rays {}{only} -o DIR",
            args.common.frames, args.rays
        );
        Self {
            setup: Setup::new(command, args.common.frames, args.common.size),
            path_size: path_size(args),
            rays: args.rays,
            samples: OcclusionSettings::new(Estimator::Issao, 1.0).samples,
            untuned: Estimator::ALL.iter().filter(|e| unknown(e)).map(|e| e.name().into()).collect(),
            checks: Vec::new(),
            scenes: Vec::new(),
            peers: None,
            sheets: Vec::new(),
            skipped: Vec::new(),
        }
    }
}

/// Returns half of the still pictures' width and height, rounded up.
fn path_size(args: &BenchAo) -> [u32; 2] {
    args.common.size.map(|s| s.div_ceil(2))
}

/// Measures a scene and draws its sheets.
fn one(args: &BenchAo, scene: &OcclusionScene, document: &mut AoResults) -> Result<()> {
    let view: OcclusionView = scene.open(&args.scenes)?;
    let truth = TruthTracer::build(&view.scene, false);
    let (cache, key) = (args.common.cache.cache(&args.common.output), scene_key(&view.scene, false));
    let gpu = Gpu::request(&args.common.device.gpu_options())?;
    document.setup.draw_on(&gpu);
    let camera = view.camera(args.common.size);
    let mut stage = OcclusionStage::new(gpu, &view.scene, SceneOptions::default(), camera)?;
    let radius_world = view.radius_world;
    let reference =
        OcclusionReference { truth: &truth, cache: &cache, scene: &key, radius_world, rays: args.rays };
    let traced_view = reference.trace_view(&stage)?;
    let path = view.path(path_size(args));
    let probe = crate::occlusion::ClaimProbe::new(&traced_view, radius_world);
    let [edge_share, flat_share] = probe.shares();
    let mut figures = SceneFigures {
        name: scene.name.into(),
        title: scene.title.into(),
        fold: scene.fold,
        tuned_on: TunedOn::without(scene.name),
        radius_world,
        camera: camera_figures(scene.name, &camera),
        pixels: traced_view.pixels,
        standard_error: truth.measured_error(
            &traced_view.surfaces,
            &traced_view.truth,
            radius_world,
            args.rays,
            ERROR_STEP,
        ),
        standard_error_bound: traced_view.error_bound(args.rays),
        none: traced_view.errors_of_none(),
        truth_flicker: truth_flicker(&reference, &path[..FLOOR_FRAMES])?,
        edge_share,
        flat_share,
        rows: Vec::new(),
        variants: Vec::new(),
        sweep: Vec::new(),
        equal_time: None,
    };
    let on = figures.tuned_on;
    let mut bench =
        Bench { args, reference, traced_view: &traced_view, stage: &mut stage, on, wall_time: false };
    let mut pictures = Vec::new();
    figures.rows = bench.rows(&probe, &mut pictures)?;
    figures.variants = bench.variants(&probe, &mut pictures, &mut document.skipped)?;
    figures.sweep = bench.sweep()?;
    figures.equal_time = bench.equal_time(&figures.sweep)?;
    bench.flicker(&path, &mut figures)?;
    document.setup.wall_time |= bench.wall_time;
    document.scenes.push(figures);
    // Saved now, because drawing the pictures may still fail.
    write(args, document)?;
    let Some(figures) = document.scenes.last() else { return Ok(()) };
    for (name, caption, sheet) in sheets::all(figures, &traced_view, &pictures)? {
        keep_sheet(&args.common.output, &mut document.sheets, &name, caption, &sheet)?;
    }
    Ok(())
}

/// Writes the results measured so far.
fn write(args: &BenchAo, document: &mut AoResults) -> Result<()> {
    document.checks = checks::all(document);
    if !document.scenes.is_empty() {
        sweep::plot(&args.common.output.join("ao-time.svg"), document)?;
    }
    super::write(&args.common.output, "ao", &tables::markdown(document), document)
}
