//! Every estimator with its filter and without: times side by side, errors, pictures' metrics, flicker.

use adumbra::camera::Camera;
use adumbra_lab::compare::{median_ratio, median_time, ratio_range, take_turns};
use adumbra_lab::metrics::{flip, ssim};
use adumbra_lab::occlusion::{ClaimProbe, Claims, Flicker, OcclusionErrors, grey_picture, path_flicker};
use adumbra_render::occlusion::{Estimator, Filter, OcclusionPasses, OcclusionSettings};
use adumbra_render::{FrameTimes, Stage};
use serde::Serialize;

use super::{Bench, SceneFigures};
use crate::exit::Failure;

/// A name and its visibility.
pub(super) type Pictures = Vec<(String, Vec<f32>)>;

/// An estimator's figures; milliseconds are medians.
#[derive(Serialize)]
pub(super) struct Row {
    pub(super) estimator: &'static str,
    /// Name and value of each number that shapes it.
    pub(super) settings: Vec<(&'static str, f64)>,
    pub(super) surface_ms: f64,
    pub(super) estimate_ms: f64,
    pub(super) filter_ms: f64,
    /// All passes.
    pub(super) ms: f64,
    /// All but the filter.
    pub(super) raw_ms: f64,
    /// Both by alchemy's, frame by frame.
    pub(super) by_alchemy: f64,
    pub(super) raw_by_alchemy: f64,
    /// Least and most of the frames that the first is the median of.
    pub(super) by_alchemy_range: [f64; 2],
    pub(super) filtered: Judgement,
    pub(super) raw: Judgement,
}

/// A picture beside the truth.
#[derive(Serialize)]
pub(super) struct Judgement {
    pub(super) errors: OcclusionErrors,
    pub(super) ssim: f64,
    pub(super) flip: f64,
    pub(super) claims: Claims,
    pub(super) flicker: Option<Flicker>,
}

/// All passes but the filter.
fn raw(t: &FrameTimes) -> f64 {
    t.ambient() - t.of(Stage::AmbientFilter)
}

pub(super) fn unfiltered(mut settings: OcclusionSettings) -> OcclusionSettings {
    settings.filter = Filter::None;
    settings
}

/// Its parameters, without those that are words.
fn numbers(settings: &OcclusionSettings) -> Vec<(&'static str, f64)> {
    let parameters = settings.estimator.parameters().iter().zip(settings.shape);
    parameters.filter(|(p, _)| p.words.is_empty()).map(|(p, value)| (p.name, value)).collect()
}

impl Bench<'_, '_, '_> {
    /// Frames of each of `passes`, in turns; what a first frame makes is not timed.
    pub(super) fn times(
        &mut self,
        passes: &mut [OcclusionPasses],
        frames: u32,
    ) -> Result<Vec<Vec<FrameTimes>>, Failure> {
        for p in &mut *passes {
            self.stage.occlude(p)?;
        }
        let times = take_turns(passes.len(), frames, |at| self.stage.occlude(&mut passes[at]))?;
        self.wall_time |= times.iter().flatten().any(|t| t.wall_time);
        Ok(times)
    }

    /// A row an estimator; keeps every picture.
    pub(super) fn rows(
        &mut self,
        probe: &ClaimProbe<'_>,
        pictures: &mut Pictures,
    ) -> Result<Vec<Row>, Failure> {
        let gpu = self.stage.gpu();
        let mut passes = Estimator::ALL.map(|e| OcclusionPasses::new(gpu, self.settings(e)));
        let times = self.times(&mut passes, self.args.frames)?;
        let beside = Estimator::ALL.iter().position(|e| *e == Estimator::Alchemy).unwrap_or(0);
        let mut rows = Vec::new();
        for ((estimator, passes), own) in Estimator::ALL.into_iter().zip(&mut passes).zip(&times) {
            let settings = *passes.settings();
            let filtered = self.stage.visibility(passes)?;
            let mut without = OcclusionPasses::new(self.stage.gpu(), unfiltered(settings));
            let unfiltered = self.stage.visibility(&mut without)?;
            let row = Row {
                estimator: estimator.name(),
                settings: numbers(&settings),
                surface_ms: median_time(own, |t| t.of(Stage::AmbientSurface)),
                estimate_ms: median_time(own, |t| t.of(Stage::AmbientEstimate)),
                filter_ms: median_time(own, |t| t.of(Stage::AmbientFilter)),
                ms: median_time(own, FrameTimes::ambient),
                raw_ms: median_time(own, raw),
                by_alchemy: median_ratio(own, &times[beside], FrameTimes::ambient),
                raw_by_alchemy: median_ratio(own, &times[beside], raw),
                by_alchemy_range: ratio_range(own, &times[beside], FrameTimes::ambient),
                filtered: self.judgement(probe, &filtered)?,
                raw: self.judgement(probe, &unfiltered)?,
            };
            eprintln!(
                "{estimator}: {:.1} ms, {:.2} of alchemy's; RMSE {:.4}, without filter {:.4}, of none {:.4}",
                row.ms,
                row.by_alchemy,
                row.filtered.errors.rmse,
                row.raw.errors.rmse,
                self.judged.errors_of_none().rmse
            );
            rows.push(row);
            pictures.push((estimator.name().to_owned(), filtered));
            pictures.push((format!("{estimator}:filter=none"), unfiltered));
        }
        Ok(rows)
    }

    fn judgement(&self, probe: &ClaimProbe<'_>, visibility: &[f32]) -> Result<Judgement, Failure> {
        let [truth, own] = [&self.judged.truth, visibility].map(|v| grey_picture(self.args.size, v));
        let (truth, own) = (truth?, own?);
        Ok(Judgement {
            errors: self.judged.errors(visibility)?,
            ssim: ssim(&truth, &own)?,
            flip: flip(&truth, &own)?,
            claims: probe.claims(visibility)?,
            flicker: None,
        })
    }

    /// Fills in the flicker of every row, and of the variants that are tuned. The stage is left at the path's end.
    pub(super) fn flicker(&mut self, path: &[Camera], figures: &mut SceneFigures) -> Result<(), Failure> {
        let rows = Estimator::ALL.into_iter().flat_map(|e| {
            let settings = self.settings(e);
            [settings, unfiltered(settings)]
        });
        let variants: Vec<OcclusionSettings> =
            figures.variants.iter().filter(|v| v.tuned).map(|v| v.settings).collect();
        let gpu = self.stage.gpu();
        let mut passes: Vec<OcclusionPasses> =
            rows.chain(variants).map(|s| OcclusionPasses::new(gpu, s)).collect();
        let mut found = path_flicker(self.stage, path, &mut passes)?.into_iter();
        for row in &mut figures.rows {
            row.filtered.flicker = found.next().flatten();
            row.raw.flicker = found.next().flatten();
        }
        for variant in figures.variants.iter_mut().filter(|v| v.tuned) {
            variant.flicker = found.next().flatten();
        }
        Ok(())
    }
}
