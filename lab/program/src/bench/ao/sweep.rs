//! Error against time by number of taps, and issao compared with gtao at equal time.

use std::borrow::Cow;
use std::path::Path;

use adumbra_render::FrameTimes;
use adumbra_render::occlusion::{Estimator, OcclusionPasses};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{AoResults, Bench, SceneFigures};
use crate::results::or_nan;
use adumbra_compare::Result;
use adumbra_compare::compare::{median_ratio, median_time};
use adumbra_html::plot::{Along, Legend, Panel, Series, write_svg};

pub(super) const SAMPLES: [u32; 8] = [4, 8, 12, 16, 24, 32, 48, 64];
/// Maximum number of frames that a time is the median of.
const FRAMES: u32 = 3;
/// Maximum number of tap counts tried. Each is one less than the last, as long as issao is too slow.
const TRIES: u32 = 6;

/// The results of an estimator with its filter at one number of taps.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Point {
    /// Name of the estimator.
    pub(crate) estimator: Cow<'static, str>,
    /// Taps per pixel.
    pub(crate) samples: u32,
    /// Median milliseconds of all passes.
    pub(crate) ms: f64,
    /// Root mean square error of visibility.
    pub(crate) rmse: f64,
}

/// The results of issao with as many taps as gtao's time allows.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct EqualTime {
    /// Taps per pixel of issao.
    pub(crate) issao_samples: u32,
    /// Median milliseconds of issao.
    pub(crate) issao_ms: f64,
    /// Median milliseconds of gtao.
    pub(crate) gtao_ms: f64,
    /// issao's time divided by gtao's, the median of the ratios frame by frame.
    #[serde(deserialize_with = "or_nan")]
    #[schemars(with = "Option<f64>")]
    pub(crate) ratio: f64,
    /// Root mean square error of issao.
    pub(crate) issao_rmse: f64,
    /// Root mean square error of gtao.
    pub(crate) gtao_rmse: f64,
}

impl Bench<'_, '_, '_> {
    fn passes(&self, estimator: Estimator, samples: u32) -> OcclusionPasses {
        let mut settings = self.settings(estimator);
        settings.samples = samples;
        OcclusionPasses::new(self.stage.gpu(), settings)
    }

    pub(super) fn sweep(&mut self) -> Result<Vec<Point>> {
        let mut points = Vec::new();
        for samples in SAMPLES {
            let mut passes = Estimator::ALL.map(|e| self.passes(e, samples));
            let times = self.times(&mut passes, self.args.common.frames.min(FRAMES))?;
            for ((estimator, passes), own) in Estimator::ALL.into_iter().zip(&mut passes).zip(&times) {
                let rmse = self.traced_view.errors(&self.stage.visibility(passes)?)?.rmse;
                let ms = median_time(own, FrameTimes::ambient);
                points.push(Point { estimator: estimator.name().into(), samples, ms, rmse });
            }
        }
        Ok(points)
    }

    /// Finds the largest number of issao's taps that takes no longer than gtao with 12, timed in alternation.
    ///
    /// The search starts at the number of taps at which the sweep's times are equal, and goes down. After
    /// [`TRIES`] attempts the last number is taken, even if issao is still slower.
    pub(super) fn equal_time(&mut self, sweep: &[Point]) -> Result<Option<EqualTime>> {
        let of = |e: Estimator| sweep.iter().filter(move |p| p.estimator == e.name());
        let allowed = of(Estimator::Gtao).find(|p| p.samples == 12).map(|p| p.ms);
        let Some(allowed) = allowed else { return Ok(None) };
        let issao: Vec<&Point> = of(Estimator::Issao).collect();
        let mut samples = meeting(&issao, allowed);
        for tried in 1..=TRIES {
            let mut passes = [self.passes(Estimator::Issao, samples), self.passes(Estimator::Gtao, 12)];
            let times = self.times(&mut passes, self.args.common.frames)?;
            let ratio = median_ratio(&times[0], &times[1], FrameTimes::ambient);
            if ratio > 1.0 && samples > SAMPLES[0] && tried < TRIES {
                samples -= 1;
                continue;
            }
            let [issao, gtao] = &mut passes;
            let found = EqualTime {
                issao_samples: samples,
                issao_ms: median_time(&times[0], FrameTimes::ambient),
                gtao_ms: median_time(&times[1], FrameTimes::ambient),
                ratio,
                issao_rmse: self.traced_view.errors(&self.stage.visibility(issao)?)?.rmse,
                gtao_rmse: self.traced_view.errors(&self.stage.visibility(gtao)?)?.rmse,
            };
            adumbra_program::note!(
                "issao with {samples} taps, {:.2} × gtao's time: RMSE {:.4} against {:.4}",
                found.ratio,
                found.issao_rmse,
                found.gtao_rmse
            );
            return Ok(Some(found));
        }
        Ok(None)
    }
}

/// Returns the taps at which the linearly interpolated times reach
/// `allowed`, clamped to the range of `points`.
fn meeting(points: &[&Point], allowed: f64) -> u32 {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return SAMPLES[0] };
    let crossing = points.windows(2).find(|p| p[0].ms <= allowed && p[1].ms > allowed);
    let Some(&[below, above]) = crossing else {
        return if allowed < first.ms { first.samples } else { last.samples };
    };
    let share = (allowed - below.ms) / (above.ms - below.ms);
    below.samples + (share * f64::from(above.samples - below.samples)) as u32
}

/// Returns an estimator's time and its RMSE divided by that of open sky, both averaged over the scenes.
pub(super) fn mean(scenes: &[SceneFigures], estimator: Estimator, samples: u32) -> Option<[f64; 2]> {
    let points: Vec<[f64; 2]> = scenes
        .iter()
        .filter_map(|s| {
            let wanted = |p: &&Point| p.estimator == estimator.name() && p.samples == samples;
            s.sweep.iter().find(wanted).map(|p| [p.ms, p.rmse / s.none.rmse])
        })
        .collect();
    let count = points.len() as f64;
    (!points.is_empty()).then(|| [0, 1].map(|i| points.iter().map(|p| p[i]).sum::<f64>() / count))
}

/// Draws both plots: error against time, and against taps.
pub(super) fn plot(path: &Path, document: &AoResults) -> Result<()> {
    let series = |of: &dyn Fn(u32, [f64; 2]) -> (f64, f64)| {
        let one = |e: Estimator| Series {
            name: e.name().to_owned(),
            points: SAMPLES
                .into_iter()
                .filter_map(|n| mean(&document.scenes, e, n).map(|m| of(n, m)))
                .collect(),
        };
        Estimator::ALL.map(one).into()
    };
    let panel = |title: &str, along, series| Panel {
        title: title.to_owned(),
        along: Along::Powers(along),
        y_label: "RMSE relative to no occlusion",
        logarithmic: false,
        legend: Legend::UpperRight,
        series,
    };
    let panels = [
        panel(
            "Error against time, 4 to 64 taps",
            "milliseconds",
            series(&|_, [ms, error]| (ms.log2(), error)),
        ),
        panel("Error against taps", "taps", series(&|n, [_, error]| (f64::from(n).log2(), error))),
    ];
    Ok(write_svg(path, &panels)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meeting_interpolates_and_clamps_tap_count() {
        let point = |samples, ms| Point { estimator: "issao".into(), samples, ms, rmse: 0.1 };
        let points = [point(4, 1.0), point(8, 2.0), point(16, 4.0)];
        let points: Vec<&Point> = points.iter().collect();
        assert_eq!(meeting(&points, 0.5), 4);
        assert_eq!(meeting(&points, 1.6), 6);
        assert_eq!(meeting(&points, 3.9), 15);
        assert_eq!(meeting(&points, 9.0), 16);
    }
}
