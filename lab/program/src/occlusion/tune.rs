//! Tunes the parameters of every estimator of ambient occlusion with the same search, for
//! `adumbra-lab tune-ao`.
//!
//! Each estimator varies the parameters that its own list marks for search
//! ([`adumbra_render::occlusion::ShapeParameter::search`]). Radius, samples, noise and filter are the same
//! for all. The objective to minimise is the mean over scenes of RMSE after the filter, divided by that of
//! open sky everywhere.
//!
//! A run is a fixed number of evaluations. A third of them cover the whole box of parameters along a sequence
//! that fills it evenly (M. Roberts, *The Unreasonable Effectiveness of Quasirandom Sequences*, 2018). The
//! rest are Nelder and Mead's simplex method, which starts at the best of these points. The search is
//! deterministic, so a run is repeatable on the same adapter.

use std::collections::HashMap;
use std::path::Path;

use adumbra_render::occlusion::{
    Estimator, MAX_PARAMETERS, OcclusionPasses, OcclusionSettings, Search, ShapeParameter,
};
use adumbra_render::{Gpu, SceneOptions};
use adumbra_scene::{Camera, Scene};

use super::measure::{OcclusionReference, OcclusionStage, TracedView};
use super::record::{Record, RecordEntry, RecordScene, TunedOn};
use super::views::{Fold, SCENES};
use adumbra_compare::error::Result;
use adumbra_compare::truth::{Cache, TruthTracer, scene_key};

/// Edge length of the first simplex, as a share of the side of the box.
const FIRST_EDGE: f64 = 0.12;
/// Significant digits of a parameter. Values are rounded before they are tried, so that the record is exact.
const DIGITS: i32 = 4;

/// Options of the tuner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TuneOptions {
    /// Evaluations per run, each over all scenes of the run.
    pub budget: u32,
    /// Size of the pictures in pixels.
    pub size: [u32; 2],
    /// Rays per pixel of the truth.
    pub rays: u32,
}

impl Default for TuneOptions {
    fn default() -> Self {
        Self { budget: 120, size: [640, 360], rays: 256 }
    }
}

/// A view that estimators are tuned on.
pub struct TuneScene {
    name: String,
    fold: Fold,
    stage: OcclusionStage,
    traced_view: TracedView,
    radius_world: f64,
    none_rmse: f64,
}

impl TuneScene {
    /// Draws the scene on `gpu`, which other scenes may share ([`Gpu::sharing`]), and traces its truth.
    ///
    /// # Errors
    /// Returns the errors of the renderer.
    pub fn new(
        gpu: Gpu,
        (name, fold): (&str, Fold),
        scene: &Scene,
        camera: Camera,
        radius_world: f64,
        rays: u32,
        cache: &Cache,
    ) -> Result<Self> {
        let stage = OcclusionStage::new(gpu, scene, SceneOptions::default(), camera)?;
        let truth = TruthTracer::build(scene, false);
        let key = scene_key(scene, false);
        let reference = OcclusionReference { truth: &truth, cache, scene: &key, radius_world, rays };
        let traced_view = reference.trace_view(&stage)?;
        let none_rmse = traced_view.errors_of_none().rmse;
        Ok(Self { name: name.to_owned(), fold, stage, traced_view, radius_world, none_rmse })
    }

    /// Loads the eight scenes of [`SCENES`] from files in `folder`, all on one device.
    ///
    /// Cost: tracing the truths that are not cached yet, about a minute each.
    ///
    /// # Errors
    /// Returns an error if a scene is absent, and the errors of the renderer.
    pub fn all(gpu: &Gpu, folder: &Path, options: &TuneOptions, cache: &Cache) -> Result<Vec<Self>> {
        let open = |scene: &super::OcclusionScene| {
            let view = scene.open(folder)?;
            let gpu = Gpu::sharing(&gpu.device, &gpu.queue);
            let camera = view.camera(options.size);
            let named = (scene.name, scene.fold);
            Self::new(gpu, named, &view.scene, camera, view.radius_world, options.rays, cache)
        };
        SCENES.iter().map(open).collect()
    }

    fn record(&self) -> RecordScene {
        RecordScene {
            name: self.name.clone(),
            fold: self.fold,
            radius_world: rounded(self.radius_world, DIGITS),
            none_rmse: rounded(self.none_rmse, DIGITS),
        }
    }
}

/// Tunes estimators on fold A, fold B and all scenes, and calls `done` with each run's entry.
///
/// Each of `settings` supplies the parameters that do not vary. The scenes must be on one device.
///
/// Cost: at most 5 · budget · scenes / 3 pictures per estimator, because the run on all scenes reuses both
/// folds' evaluations over the whole box.
///
/// # Errors
/// Returns the errors of the device.
pub fn tune(
    scenes: &[TuneScene],
    options: &TuneOptions,
    settings: &[OcclusionSettings],
    mut done: impl FnMut(&RecordEntry),
) -> Result<Record> {
    let mut record = Record {
        adapter: scenes.first().map_or_else(String::new, |s| s.stage.gpu().name()),
        size: options.size,
        rays: options.rays,
        samples: OcclusionSettings::new(Estimator::Issao, 1.0).samples,
        budget: options.budget,
        scenes: scenes.iter().map(TuneScene::record).collect(),
        entries: Vec::new(),
    };
    for &settings in settings {
        let mut tuner = Tuner::new(scenes, settings);
        for on in TunedOn::ALL {
            let entry = tuner.run(on, options.budget)?;
            done(&entry);
            record.entries.push(entry);
        }
    }
    Ok(record)
}

/// Runs `budget` evaluations of Nelder and Mead's method, starting from a point with its value.
fn simplex(
    best: (f64, Vec<f64>),
    budget: u32,
    mut objective: impl FnMut(&[f64]) -> Result<f64>,
) -> Result<(f64, Vec<f64>)> {
    let mut left = budget;
    let mut corners = vec![best];
    for axis in 0..corners[0].1.len() {
        if left == 0 {
            break;
        }
        let mut point = corners[0].1.clone();
        point[axis] += if point[axis] > 0.5 { -FIRST_EDGE } else { FIRST_EDGE };
        left -= 1;
        corners.push((objective(&point)?, point));
    }
    let order = |corners: &mut Vec<(f64, Vec<f64>)>| corners.sort_by(|a, b| a.0.total_cmp(&b.0));
    order(&mut corners);
    while left > 0 && corners.len() > 1 {
        let (others, worst) = corners.split_at(corners.len() - 1);
        let (count, worst) = (others.len() as f64, worst[0].clone());
        let middle: Vec<f64> =
            (0..worst.1.len()).map(|a| others.iter().map(|c| c.1[a]).sum::<f64>() / count).collect();
        // The line from the worst corner through the centroid of the others.
        let along = |t: f64| -> Vec<f64> {
            middle.iter().zip(&worst.1).map(|(m, w)| (m + t * (m - w)).clamp(0.0, 1.0)).collect()
        };
        let (first, last) = (others[0].0, others[others.len() - 1].0);
        let mut ask = |t: f64| -> Result<(f64, Vec<f64>)> {
            left = left.saturating_sub(1);
            let point = along(t);
            Ok((objective(&point)?, point))
        };
        let reflected = ask(1.0)?;
        let found = if reflected.0 < first {
            let expanded = ask(2.0)?;
            if expanded.0 < reflected.0 { expanded } else { reflected }
        } else if reflected.0 < last {
            reflected
        } else {
            let contracted = ask(if reflected.0 < worst.0 { 0.5 } else { -0.5 })?;
            if contracted.0 < worst.0.min(reflected.0) { contracted } else { worst.clone() }
        };
        let stuck = found == worst;
        if let Some(corner) = corners.last_mut() {
            *corner = found;
        }
        if stuck {
            // Shrink the simplex towards the best corner.
            let best = corners[0].1.clone();
            for corner in corners.iter_mut().skip(1).take(left as usize) {
                corner.1.iter_mut().zip(&best).for_each(|(c, b)| *c = 0.5 * (*c + b));
                corner.0 = objective(&corner.1)?;
            }
            left = left.saturating_sub(best.len() as u32);
        }
        order(&mut corners);
    }
    Ok(corners.swap_remove(0))
}

/// One estimator's search.
struct Tuner<'a> {
    scenes: &'a [TuneScene],
    settings: OcclusionSettings,
    /// Index in the shape of each varied parameter, its search range and its description.
    varied: Vec<(usize, Search, &'static ShapeParameter)>,
    passes: Option<OcclusionPasses>,
    /// RMSE by scene of every shape tried so far.
    known: HashMap<[u64; MAX_PARAMETERS], Vec<Option<f64>>>,
}

impl<'a> Tuner<'a> {
    fn new(scenes: &'a [TuneScene], settings: OcclusionSettings) -> Self {
        let parameters = settings.estimator.parameters().iter().enumerate();
        let varied = parameters.filter_map(|(i, p)| p.search.map(|s| (i, s, p))).collect();
        let passes = scenes.first().map(|s| OcclusionPasses::new(s.stage.gpu(), settings));
        Self { scenes, settings, varied, passes, known: HashMap::new() }
    }

    fn run(&mut self, on: TunedOn, budget: u32) -> Result<RecordEntry> {
        let inside = |s: &TuneScene| on.has(s.fold);
        let mut points = sequence(self.varied.len());
        let mut next = || points.next().unwrap_or_default();
        // With nothing to vary, one evaluation is enough.
        let budget = if self.varied.is_empty() { 1 } else { budget.max(1) };
        let wide = budget.div_ceil(3);
        let mut tried = 0;
        let mut best = (f64::INFINITY, Vec::new());
        for _ in 0..wide {
            let point = next();
            let objective = self.objective(&point, &inside)?;
            tried += 1;
            if objective < best.0 {
                best = (objective, point);
            }
        }
        let (least, best) = simplex(best, budget - tried, |point| self.objective(point, &inside))?;
        let shape = self.shape(&best);
        let rmse = self.rmse(&shape, &|_| true)?;
        let elsewhere = if on == TunedOn::All { None } else { self.mean(&rmse, &|s| !inside(s)) };
        Ok(RecordEntry {
            estimator: self.settings.estimator.name().to_owned(),
            on,
            settings: self.varied.iter().map(|&(i, _, p)| (p.name.to_owned(), shape[i])).collect(),
            objective: rounded(least, DIGITS),
            elsewhere: elsewhere.map(|e| rounded(e, DIGITS)),
            rmse: self
                .scenes
                .iter()
                .zip(&rmse)
                .map(|(s, e)| (s.name.clone(), rounded(e.unwrap_or(f64::NAN), DIGITS)))
                .collect(),
        })
    }

    fn objective(&mut self, point: &[f64], inside: &dyn Fn(&TuneScene) -> bool) -> Result<f64> {
        let rmse = self.rmse(&self.shape(point), inside)?;
        Ok(self.mean(&rmse, inside).unwrap_or(f64::INFINITY))
    }

    /// Returns the mean of RMSE divided by that of open sky, or `None` without scenes.
    fn mean(&self, rmse: &[Option<f64>], inside: &dyn Fn(&TuneScene) -> bool) -> Option<f64> {
        let of = |(s, e): (&TuneScene, &Option<f64>)| e.filter(|_| inside(s)).map(|e| e / s.none_rmse);
        let shares: Vec<f64> = self.scenes.iter().zip(rmse).filter_map(of).collect();
        (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64)
    }

    /// Returns RMSE by scene, computing it for requested scenes where it is not known yet.
    fn rmse(
        &mut self,
        shape: &[f64; MAX_PARAMETERS],
        inside: &dyn Fn(&TuneScene) -> bool,
    ) -> Result<Vec<Option<f64>>> {
        let known =
            self.known.entry(shape.map(f64::to_bits)).or_insert_with(|| vec![None; self.scenes.len()]);
        let Some(passes) = &mut self.passes else { return Ok(Vec::new()) };
        for (scene, known) in self.scenes.iter().zip(known.iter_mut()) {
            if known.is_some() || !inside(scene) {
                continue;
            }
            let settings = shaped(self.settings, *shape, scene.radius_world);
            passes.reshape(scene.stage.gpu(), &settings);
            *known = Some(scene.traced_view.errors(&scene.stage.visibility(passes)?)?.rmse);
        }
        Ok(known.clone())
    }

    /// Returns the parameters at a point of the unit box.
    fn shape(&self, point: &[f64]) -> [f64; MAX_PARAMETERS] {
        let mut shape = self.settings.shape;
        for (&(i, search, _), u) in self.varied.iter().zip(point) {
            shape[i] = rounded(value(search, *u), DIGITS);
        }
        shape
    }
}

fn shaped(mut s: OcclusionSettings, shape: [f64; MAX_PARAMETERS], radius_world: f64) -> OcclusionSettings {
    s.shape = shape;
    s.radius_world = radius_world;
    s
}

fn value(search: Search, u: f64) -> f64 {
    match search {
        Search::Even(low, high) => low + u * (high - low),
        Search::Factors(low, high) => low * libm::pow(high / low, u),
    }
}

/// Rounds to `digits` significant decimal digits.
fn rounded(value: f64, digits: i32) -> f64 {
    format!("{value:.*e}", (digits - 1).max(0) as usize).parse().unwrap_or(value)
}

/// Returns points that fill the unit box evenly.
///
/// They are multiples of the powers of 1/φ, where φ is the root above 1 of φ^(d + 1) = φ + 1 in d dimensions.
fn sequence(dimensions: usize) -> impl Iterator<Item = Vec<f64>> {
    let exponent = 1.0 / (dimensions as f64 + 1.0);
    let root = (0..64).fold(2.0, |x: f64, _| libm::pow(1.0 + x, exponent));
    let steps: Vec<f64> = (1..=dimensions).map(|k| libm::pow(root, -(k as f64))).collect();
    (1_u32..).map(move |i| steps.iter().map(|s| (0.5 + f64::from(i) * s).fract()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tuner_values_span_their_range() {
        assert_eq!([0.0, 0.5, 1.0].map(|u| value(Search::Even(-1.0, 3.0), u)), [-1.0, 1.0, 3.0]);
        let factors = [0.0, 0.5, 1.0].map(|u| rounded(value(Search::Factors(0.01, 100.0), u), 6));
        assert_eq!(factors, [0.01, 1.0, 100.0]);
        assert_eq!((rounded(1.234_56, 4), rounded(0.000_987_654, 4)), (1.235, 0.000_987_7));
    }

    #[test]
    fn tuner_points_cover_unit_box_evenly() {
        for dimensions in 1..=6 {
            let points: Vec<Vec<f64>> = sequence(dimensions).take(256).collect();
            assert!(points.iter().flatten().all(|u| (0.0..1.0).contains(u)));
            // For every pair of adjacent axes, a quarter of the square holds a quarter of the points.
            for side in 0..dimensions {
                let other = (side + 1) % dimensions;
                let quarter = |p: &&Vec<f64>| p[side] < 0.5 && (p[other] < 0.5 || dimensions == 1);
                let share = points.iter().filter(quarter).count();
                let expected = if dimensions == 1 { 128 } else { 64 };
                assert!(share.abs_diff(expected) <= 12, "{dimensions} {side}: {share}");
            }
        }
        assert_eq!(sequence(0).next(), Some(Vec::new()));
    }
}
