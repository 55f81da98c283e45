//! Every estimator with and without its filter: times taken in alternation, errors, image metrics, flicker.

use adumbra_render::occlusion::{Estimator, Filter, OcclusionPasses, OcclusionSettings};
use adumbra_render::{FrameTimes, Stage};
use adumbra_scene::Camera;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use super::{Bench, SceneFigures};
use crate::occlusion::{ClaimProbe, Claims, Flicker, OcclusionErrors, grey_picture, path_flicker};
use crate::results::{or_nan, pair_or_nan};
use adumbra_compare::Result;
use adumbra_compare::compare::{median_ratio, median_time, ratio_range};
use adumbra_compare::metrics::{flip, ssim};

/// A name and its visibility.
pub(super) type Pictures = Vec<(String, Vec<f32>)>;

/// An estimator's results; milliseconds are medians.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "AoRow")]
pub(crate) struct Row {
    /// Name of the estimator.
    pub(crate) estimator: Cow<'static, str>,
    /// Name and value of each of its numeric parameters.
    pub(crate) settings: Vec<(Cow<'static, str>, f64)>,
    /// Milliseconds of view depth and normals.
    pub(crate) surface_ms: f64,
    /// Milliseconds of the estimate.
    pub(crate) estimate_ms: f64,
    /// Milliseconds of the filter.
    pub(crate) filter_ms: f64,
    /// Milliseconds of all passes.
    pub(crate) ms: f64,
    /// Milliseconds of all passes except the filter.
    pub(crate) raw_ms: f64,
    /// `ms` divided by alchemy's, the median of the ratios frame by frame.
    #[serde(deserialize_with = "or_nan")]
    #[schemars(with = "Option<f64>")]
    pub(crate) by_alchemy: f64,
    /// `raw_ms` divided by alchemy's, the median of the ratios frame by frame.
    #[serde(deserialize_with = "or_nan")]
    #[schemars(with = "Option<f64>")]
    pub(crate) raw_by_alchemy: f64,
    /// Least and greatest of the ratios that `by_alchemy` is the median of.
    #[serde(deserialize_with = "pair_or_nan")]
    #[schemars(with = "[Option<f64>; 2]")]
    pub(crate) by_alchemy_range: [f64; 2],
    /// The picture with the filter.
    pub(crate) filtered: PictureFigures,
    /// The picture without the filter.
    pub(crate) raw: PictureFigures,
}

/// A picture compared with the truth.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct PictureFigures {
    /// Errors with the filter.
    pub(crate) errors: OcclusionErrors,
    /// Structural similarity with the truth.
    pub(crate) ssim: f64,
    /// FLIP against the truth.
    pub(crate) flip: f64,
    /// Measures of detail, edges and noise.
    pub(crate) claims: Claims,
    /// Flicker along the camera path; `None` if it was not measured.
    pub(crate) flicker: Option<Flicker>,
}

/// Returns the time of all passes but the filter.
fn raw(t: &FrameTimes) -> f64 {
    t.ambient() - t.of(Stage::AmbientFilter)
}

pub(super) fn unfiltered(mut settings: OcclusionSettings) -> OcclusionSettings {
    settings.filter = Filter::None;
    settings
}

/// Returns the numeric parameters by name.
fn numbers(settings: &OcclusionSettings) -> Vec<(Cow<'static, str>, f64)> {
    let parameters = settings.estimator.parameters().iter().zip(settings.shape);
    parameters.filter(|(p, _)| p.words.is_empty()).map(|(p, value)| (p.name.into(), value)).collect()
}

impl Bench<'_, '_, '_> {
    /// Times `frames` frames of each of `passes` in alternation.
    ///
    /// One untimed frame comes first, to create the resources of later frames.
    pub(super) fn times(
        &mut self,
        passes: &mut [OcclusionPasses],
        frames: u32,
    ) -> Result<Vec<Vec<FrameTimes>>> {
        for p in &mut *passes {
            self.stage.occlude(p)?;
        }
        let times = self.stage.times(passes, frames)?;
        self.wall_time |= times.iter().flatten().any(|t| t.wall_time);
        Ok(times)
    }

    /// Measures one row per estimator, and adds every picture to `pictures`.
    pub(super) fn rows(&mut self, probe: &ClaimProbe<'_>, pictures: &mut Pictures) -> Result<Vec<Row>> {
        let gpu = self.stage.gpu();
        let mut passes = Estimator::ALL.map(|e| OcclusionPasses::new(gpu, self.settings(e)));
        let times = self.times(&mut passes, self.args.common.frames)?;
        let beside = Estimator::ALL.iter().position(|e| *e == Estimator::Alchemy).unwrap_or(0);
        let mut rows = Vec::new();
        for ((estimator, passes), own) in Estimator::ALL.into_iter().zip(&mut passes).zip(&times) {
            let settings = *passes.settings();
            let filtered = self.stage.visibility(passes)?;
            let mut without = OcclusionPasses::new(self.stage.gpu(), unfiltered(settings));
            let unfiltered = self.stage.visibility(&mut without)?;
            let row = Row {
                estimator: estimator.name().into(),
                settings: numbers(&settings),
                surface_ms: median_time(own, |t| t.of(Stage::AmbientSurface)),
                estimate_ms: median_time(own, |t| t.of(Stage::AmbientEstimate)),
                filter_ms: median_time(own, |t| t.of(Stage::AmbientFilter)),
                ms: median_time(own, FrameTimes::ambient),
                raw_ms: median_time(own, raw),
                by_alchemy: median_ratio(own, &times[beside], FrameTimes::ambient),
                raw_by_alchemy: median_ratio(own, &times[beside], raw),
                by_alchemy_range: ratio_range(own, &times[beside], FrameTimes::ambient),
                filtered: self.picture_figures(probe, &filtered)?,
                raw: self.picture_figures(probe, &unfiltered)?,
            };
            adumbra_program::note!(
                "{estimator}: {:.1} ms, {:.2} × alchemy's; RMSE {:.4}, without filter {:.4}, without occlusion {:.4}",
                row.ms,
                row.by_alchemy,
                row.filtered.errors.rmse,
                row.raw.errors.rmse,
                self.traced_view.errors_of_none().rmse
            );
            rows.push(row);
            pictures.push((estimator.name().to_owned(), filtered));
            pictures.push((format!("{estimator}:filter=none"), unfiltered));
        }
        Ok(rows)
    }

    fn picture_figures(&self, probe: &ClaimProbe<'_>, visibility: &[f32]) -> Result<PictureFigures> {
        let truth = grey_picture(self.args.common.size, &self.traced_view.truth)?;
        let own = grey_picture(self.args.common.size, visibility)?;
        Ok(PictureFigures {
            errors: self.traced_view.errors(visibility)?,
            ssim: ssim(&truth, &own)?,
            flip: flip(&truth, &own)?,
            claims: probe.claims(visibility)?,
            flicker: None,
        })
    }

    /// Fills in the flicker of every row and of the tuned variants. The stage is left at the path's last
    /// camera.
    pub(super) fn flicker(&mut self, path: &[Camera], figures: &mut SceneFigures) -> Result<()> {
        let rows = Estimator::ALL.into_iter().flat_map(|e| {
            let settings = self.settings(e);
            [settings, unfiltered(settings)]
        });
        let variants: Vec<OcclusionSettings> =
            figures.variants.iter().filter(|v| v.tuned).filter_map(|v| v.settings).collect();
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
