//! The requirements and their outcome.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::rows::{
    BOX_CITY, EIGHT, EIGHT_RESOLUTION, Figure, INTERIOR, Limit, QUERY, RATIO, RATIO_OF, SUM, rows,
};
use super::{FastResults, Figures};

/// A requirement and its outcome.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "BakeCheck")]
pub(crate) struct Check {
    /// What is measured: a bake, or several together.
    pub(super) row: String,
    /// The bounded figure.
    pub(super) figure: Figure,
    /// `None` if it was not measured.
    pub(super) measured: Option<f64>,
    /// Value that it must keep to.
    pub(super) limit: f64,
    /// Value that it should reach; `None` if there is none.
    pub(super) aim: Option<f64>,
    /// Whether it keeps to the limit; `None` if it was not measured.
    pub(super) holds: Option<bool>,
    /// `None` if there is no aim or nothing was measured.
    pub(super) reaches_aim: Option<bool>,
}

impl Check {
    fn new(row: String, limit: Limit, measured: Option<f64>) -> Self {
        let Limit { figure, limit, aim } = limit;
        Self {
            row,
            figure,
            measured,
            limit,
            aim,
            holds: measured.map(|m| figure.within(m, limit)),
            reaches_aim: measured.zip(aim).map(|(m, aim)| figure.within(m, aim)),
        }
    }
}

/// Checks every requirement, measured or not.
pub(super) fn all(document: &FastResults) -> Vec<Check> {
    let found = |scene: &str, resolution: u64| {
        document.rows.iter().find(|r| r.scene == scene && r.resolution == resolution)
    };
    let mut checks = Vec::new();
    for row in rows() {
        let figures = found(row.scene, row.resolution);
        for &limit in row.limits.iter().chain([&INTERIOR]) {
            checks.push(Check::new(row.name(), limit, figures.map(|f| f.value(limit.figure))));
        }
    }
    let [fine, coarse] = RATIO_OF.map(|resolution| found(BOX_CITY, resolution).map(|f| f.seconds));
    let ratio = fine.zip(coarse).map(|(fine, coarse)| fine / coarse);
    checks.push(Check::new(format!("{BOX_CITY}, {} against {}", RATIO_OF[0], RATIO_OF[1]), RATIO, ratio));
    let sizes: Option<Vec<f64>> =
        EIGHT.iter().map(|scene| found(scene, EIGHT_RESOLUTION).map(|f| f.file_bytes)).collect();
    let sum = sizes.map(|s| s.iter().sum());
    checks.push(Check::new(format!("the eight scenes at {EIGHT_RESOLUTION}"), SUM, sum));
    let slowest = document.query.iter().map(|l| l.points_per_second).reduce(f64::min);
    checks.push(Check::new("look-ups on one core, at the slowest spacing".to_owned(), QUERY, slowest));
    checks
}

impl Figures {
    fn value(&self, figure: Figure) -> f64 {
        match figure {
            Figure::Seconds => self.seconds,
            Figure::PeakBytes => self.peak_bytes,
            Figure::FileBytes => self.file_bytes,
            Figure::ShadowedShare => self.shadowed_share,
            Figure::InteriorAgreement => self.interior_agreement,
            Figure::TimeRatio | Figure::SumBytes | Figure::PointsPerSecond => f64::NAN,
        }
    }
}
