//! Error against time by the number of taps, and issao beside gtao at equal time.

use std::path::Path;

use adumbra_lab::compare::{median_ratio, median_time};
use adumbra_render::FrameTimes;
use adumbra_render::occlusion::{Estimator, OcclusionPasses};
use serde::Serialize;

use super::{Bench, Document, SceneFigures};
use crate::exit::Failure;
use crate::plot::{Along, Legend, Panel, Series, write_svg};

pub(super) const SAMPLES: [u32; 8] = [4, 8, 12, 16, 24, 32, 48, 64];
/// Frames that a time is the median of, at most.
const FRAMES: u32 = 3;
/// Numbers of taps that are tried where the first is too slow.
const TRIES: u32 = 6;

/// An estimator with so many taps and its filter.
#[derive(Serialize)]
pub(super) struct Point {
    pub(super) estimator: &'static str,
    pub(super) samples: u32,
    pub(super) ms: f64,
    pub(super) rmse: f64,
}

/// issao with the taps that gtao's time allows.
#[derive(Serialize)]
pub(super) struct EqualTime {
    pub(super) issao_samples: u32,
    pub(super) issao_ms: f64,
    pub(super) gtao_ms: f64,
    /// issao's by gtao's, frame by frame.
    pub(super) ratio: f64,
    pub(super) issao_rmse: f64,
    pub(super) gtao_rmse: f64,
}

impl Bench<'_, '_, '_> {
    fn passes(&self, estimator: Estimator, samples: u32) -> OcclusionPasses {
        let mut settings = self.settings(estimator);
        settings.samples = samples;
        OcclusionPasses::new(self.stage.gpu(), settings)
    }

    pub(super) fn sweep(&mut self) -> Result<Vec<Point>, Failure> {
        let mut points = Vec::new();
        for samples in SAMPLES {
            let mut passes = Estimator::ALL.map(|e| self.passes(e, samples));
            let times = self.times(&mut passes, self.args.frames.min(FRAMES))?;
            for ((estimator, passes), own) in Estimator::ALL.into_iter().zip(&mut passes).zip(&times) {
                let rmse = self.judged.errors(&self.stage.visibility(passes)?)?.rmse;
                let ms = median_time(own, FrameTimes::ambient);
                points.push(Point { estimator: estimator.name(), samples, ms, rmse });
            }
        }
        Ok(points)
    }

    /// The largest number of issao's taps whose time, side by side, is no more than gtao's with 12: begins where the
    /// sweep's times meet.
    pub(super) fn equal_time(&mut self, sweep: &[Point]) -> Result<Option<EqualTime>, Failure> {
        let of = |e: Estimator| sweep.iter().filter(move |p| p.estimator == e.name());
        let allowed = of(Estimator::Gtao).find(|p| p.samples == 12).map(|p| p.ms);
        let Some(allowed) = allowed else { return Ok(None) };
        let issao: Vec<&Point> = of(Estimator::Issao).collect();
        let mut samples = meeting(&issao, allowed);
        for tried in 1..=TRIES {
            let mut passes = [self.passes(Estimator::Issao, samples), self.passes(Estimator::Gtao, 12)];
            let times = self.times(&mut passes, self.args.frames)?;
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
                issao_rmse: self.judged.errors(&self.stage.visibility(issao)?)?.rmse,
                gtao_rmse: self.judged.errors(&self.stage.visibility(gtao)?)?.rmse,
            };
            eprintln!(
                "issao with {samples} taps, {:.2} of gtao's time: RMSE {:.4} beside {:.4}",
                found.ratio, found.issao_rmse, found.gtao_rmse
            );
            return Ok(Some(found));
        }
        Ok(None)
    }
}

/// The taps at which the times, joined by lines, reach `allowed`; within the points' own.
fn meeting(points: &[&Point], allowed: f64) -> u32 {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return SAMPLES[0] };
    let crossing = points.windows(2).find(|p| p[0].ms <= allowed && p[1].ms > allowed);
    let Some(&[below, above]) = crossing else {
        return if allowed < first.ms { first.samples } else { last.samples };
    };
    let share = (allowed - below.ms) / (above.ms - below.ms);
    below.samples + (share * f64::from(above.samples - below.samples)) as u32
}

/// Mean over the scenes of an estimator's time and of its RMSE by that of open sky, with so many taps.
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
pub(super) fn plot(path: &Path, document: &Document) -> Result<(), Failure> {
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
        y_label: "RMSE by that of none",
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
    write_svg(path, &panels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_time_begins_where_the_times_meet() {
        let point = |samples, ms| Point { estimator: "issao", samples, ms, rmse: 0.1 };
        let points = [point(4, 1.0), point(8, 2.0), point(16, 4.0)];
        let points: Vec<&Point> = points.iter().collect();
        assert_eq!(meeting(&points, 0.5), 4);
        assert_eq!(meeting(&points, 1.6), 6);
        assert_eq!(meeting(&points, 3.9), 15);
        assert_eq!(meeting(&points, 9.0), 16);
    }
}
