//! The bakes of the suite, and the limit of each figure.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A bake of the suite.
pub(super) struct Row {
    /// File name without its extension.
    pub(super) scene: &'static str,
    pub(super) resolution: u64,
    /// Thickness in metres.
    pub(super) thickness: f64,
    pub(super) sun: [f64; 3],
    pub(super) limits: &'static [Limit],
}

impl Row {
    /// Returns the name that `--only` is matched against.
    pub(super) fn name(&self) -> String {
        format!("{}-{}", self.scene, self.resolution)
    }

    /// Returns the limit on peak memory, which is also the bake's memory budget.
    pub(super) fn max_memory_bytes(&self) -> Option<u64> {
        let peak = self.limits.iter().find(|l| l.figure == Figure::PeakBytes);
        peak.map(|peak| peak.limit as u64)
    }
}

/// A figure that is bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Figure {
    /// Wall time of the bake.
    Seconds,
    /// Largest resident size of the process.
    PeakBytes,
    /// Size of the file.
    FileBytes,
    /// Share of the compared points that are shadowed according to rays.
    ShadowedShare,
    /// Agreement with rays of the points away from edges.
    InteriorAgreement,
    /// One row's time divided by another's.
    TimeRatio,
    /// Total size of several files.
    SumBytes,
    /// Look-ups per second.
    PointsPerSecond,
}

/// The limit that a figure must keep, and the optional aim beyond it.
#[derive(Clone, Copy)]
pub(super) struct Limit {
    pub(super) figure: Figure,
    pub(super) limit: f64,
    pub(super) aim: Option<f64>,
}

impl Limit {
    const fn new(figure: Figure, limit: f64, aim: Option<f64>) -> Self {
        Self { figure, limit, aim }
    }

    const fn seconds(limit: f64, aim: Option<f64>) -> Self {
        Self::new(Figure::Seconds, limit, aim)
    }

    const fn peak(limit: f64, aim: Option<f64>) -> Self {
        Self::new(Figure::PeakBytes, limit, aim)
    }

    const fn file(limit: f64, aim: f64) -> Self {
        Self::new(Figure::FileBytes, limit, Some(aim))
    }
}

/// Required of every row.
pub(super) const INTERIOR: Limit = Limit::new(Figure::InteriorAgreement, 0.999, None);
/// Total size of the files of [`EIGHT`].
pub(super) const SUM: Limit = Limit::new(Figure::SumBytes, 8.5e6, Some(7e6));
/// Time of the finest box city divided by that of the coarsest.
pub(super) const RATIO: Limit = Limit::new(Figure::TimeRatio, 12.0, Some(8.0));
/// Resolutions of the two times that [`RATIO`] divides.
pub(super) const RATIO_OF: [u64; 2] = [262_144, 16_384];
/// Look-ups per second on one core.
pub(super) const QUERY: Limit = Limit::new(Figure::PointsPerSecond, 8e6, None);
/// Scene and resolution of the file in which look-ups are timed.
pub(super) const QUERY_OF: (&str, u64) = (BOX_CITY, 65_536);

pub(super) const BOX_CITY: &str = "box-city-51k";
/// Scenes whose files are summed, at [`EIGHT_RESOLUTION`].
pub(super) const EIGHT: [&str; 8] =
    ["kaykit_city_21", "alpine-2", "street-1", "zdm2", "delft", "bridge_garden", "box-city-5k", JACKSBORO];
pub(super) const EIGHT_RESOLUTION: u64 = 8192;
const JACKSBORO: &str = "jacksboro";

const SUN: [f64; 3] = [-0.45, 0.75, -0.35];
/// Direction towards the sun of [`EIGHT`], as in the measurements of the sketch that they are compared with.
const EIGHT_SUN: [f64; 3] = [0.5, 0.8, 0.35];
/// Direction towards a low sun, for terrain on which a high sun casts no shadows.
const LOW_SUN: [f64; 3] = [-0.77, 0.105, -0.63];

const GIB: f64 = 1_073_741_824.0;

/// Returns every bake, the cheap ones of a group first.
pub(super) fn rows() -> Vec<Row> {
    let row = |scene, resolution, thickness, sun, limits| Row { scene, resolution, thickness, sun, limits };
    let mut rows = vec![
        row(BOX_CITY, 16_384, 0.0, SUN, &[]),
        row(
            BOX_CITY,
            65_536,
            0.0,
            SUN,
            const { &[Limit::seconds(20.0, Some(8.0)), Limit::file(40e6, 28e6)] },
        ),
        row(
            BOX_CITY,
            262_144,
            0.0,
            SUN,
            const {
                &[
                    Limit::seconds(60.0, Some(30.0)),
                    Limit::peak(800e6, Some(400e6)),
                    Limit::file(150e6, 100e6),
                ]
            },
        ),
    ];
    rows.extend(EIGHT.iter().map(|&scene| {
        let sun = if scene == JACKSBORO { LOW_SUN } else { EIGHT_SUN };
        row(scene, EIGHT_RESOLUTION, 0.1, sun, &[])
    }));
    rows.extend([
        row(
            "kaykit_city_121",
            131_072,
            0.1,
            SUN,
            const {
                &[Limit::seconds(200.0, Some(120.0)), Limit::peak(2.0 * GIB, None), Limit::file(200e6, 130e6)]
            },
        ),
        row(
            JACKSBORO,
            65_536,
            0.0,
            LOW_SUN,
            const {
                &[
                    Limit::seconds(20.0, Some(8.0)),
                    Limit::peak(GIB, None),
                    Limit::new(Figure::ShadowedShare, 0.1, None),
                ]
            },
        ),
    ]);
    rows.extend(["alpine-2", "street-1"].map(|scene| {
        let limits = const { &[Limit::seconds(60.0, Some(30.0)), Limit::peak(2.0 * GIB, None)] };
        row(scene, 65_536, 0.0, SUN, limits)
    }));
    rows
}

impl Figure {
    /// Returns whether `measured` is within `bound`, which NaN never is.
    pub(super) fn within(self, measured: f64, bound: f64) -> bool {
        if self.is_floor() { measured >= bound } else { measured <= bound }
    }

    /// Returns whether the bound is a minimum.
    pub(super) fn is_floor(self) -> bool {
        matches!(self, Self::ShadowedShare | Self::InteriorAgreement | Self::PointsPerSecond)
    }

    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Seconds => "seconds",
            Self::PeakBytes => "peak memory",
            Self::FileBytes => "file size",
            Self::ShadowedShare => "shadowed share",
            Self::InteriorAgreement => "interior agreement",
            Self::TimeRatio => "time ratio",
            Self::SumBytes => "total file size",
            Self::PointsPerSecond => "points per second",
        }
    }

    /// Formats a value of this figure with its unit.
    pub(super) fn show(self, value: f64) -> String {
        match self {
            Self::Seconds => format!("{value:.1} s"),
            Self::PeakBytes => format!("{:.0} MB", value / 1e6),
            Self::FileBytes | Self::SumBytes => format!("{:.2} MB", value / 1e6),
            Self::ShadowedShare => format!("{:.1} %", 100.0 * value),
            Self::InteriorAgreement => format!("{:.3} %", 100.0 * value),
            Self::TimeRatio => format!("{value:.1} ×"),
            Self::PointsPerSecond => format!("{:.1} million", value / 1e6),
        }
    }
}
