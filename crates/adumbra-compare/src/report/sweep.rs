//! The results while the sun moves.

use adumbra_program::moment::clock;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use adumbra_html::page::Table;
use adumbra_program::format::{figure, grouped, percent};

/// Results while the sun moves across a day and the camera stands still. Shares are 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SweepReport {
    /// Number of steps, of equal time.
    pub steps: u32,
    /// Number of these in which the sun is at or below the horizon. They are left out of all other figures.
    pub nights: u32,
    /// How far the local clock is ahead of UTC in seconds; `None` of listed suns, which have no clock.
    pub utc_offset_seconds: Option<i32>,
    /// The moments that were drawn: seconds since 1970-01-01 00:00 UTC, or as the list counts them.
    pub seconds: Vec<f64>,
    /// Elevations of the sun at these moments in degrees.
    pub elevation_degrees: Vec<f64>,
    /// Number of keys of the sun path that techniques read; `None` if none reads one.
    pub keys: Option<u64>,
    /// Number of pixels that are compared in two steps that follow each other.
    pub pixels: u64,
    /// Number of pixels that are left out because G-buffer and rays see different surfaces.
    pub excluded: u64,
    /// Share of the pixels that change between lit and dark from one step to the next with rays, the mean;
    /// `None` without pixels.
    pub rays_changes: Option<f64>,
    /// The same share for each moment; `None` at the first one and after a night.
    pub rays_changes_by_step: Vec<Option<f64>>,
    /// One row per technique.
    pub techniques: Vec<SweepRow>,
}

/// One technique's results while the sun moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SweepRow {
    /// Name as requested.
    pub name: String,
    /// Share of compared pixels on the wrong side of 1/2, the mean over the moments; `None` without pixels.
    pub wrong: Option<f64>,
    /// The largest such share at a moment.
    pub worst_wrong: Option<f64>,
    /// The moment of the largest share, in the seconds of [`SweepReport::seconds`].
    pub worst_seconds: Option<f64>,
    /// The share for each moment; `None` if no pixel is compared then.
    pub wrong_by_step: Vec<Option<f64>>,
    /// Share of the pixels that change between lit and dark from one step to the next, the mean.
    pub changes: Option<f64>,
    /// The same share for each moment; `None` at the first one and after a night.
    pub changes_by_step: Vec<Option<f64>>,
    /// Changes in excess of those of rays, per pixel and step, summed over the pixels that change more often
    /// than with rays.
    pub excess: Option<f64>,
    /// The part of the excess at pixels that never change with rays.
    pub steady_excess: Option<f64>,
    /// Share of the pixels that change more often than with rays.
    pub more_often: Option<f64>,
    /// The most changes in excess at a pixel.
    pub most_excess: Option<u32>,
}

impl SweepReport {
    /// Returns a moment as its clock shows it.
    pub fn time(&self, seconds: f64) -> String {
        clock(seconds, self.utc_offset_seconds.unwrap_or_default(), self.utc_offset_seconds.is_some())
    }

    /// Returns the hour that the clock shows at a moment, or hours since the first moment if there is no
    /// clock.
    pub fn hour(&self, seconds: f64) -> f64 {
        match (self.utc_offset_seconds, self.seconds.first()) {
            // Hours continue past 24 after midnight.
            (Some(offset), Some(first)) => {
                let midnight = ((first + f64::from(offset)) / 86_400.0).floor() * 86_400.0;
                (seconds + f64::from(offset) - midnight) / 3600.0
            }
            (_, first) => (seconds - first.unwrap_or(&seconds)) / 3600.0,
        }
    }

    /// Returns a table with a row for rays, then one row per technique.
    pub fn markdown(&self) -> String {
        let head = [
            "technique",
            "wrong %",
            "worst %",
            "at",
            "changes %",
            "excess %",
            "of it steady %",
            "pixels %",
            "most at a pixel",
        ];
        let mut table = Table::new("", &head);
        let dash = || "–".to_owned();
        let rays = percent(self.rays_changes, 4);
        table.row(["rays".to_owned(), dash(), dash(), dash(), rays, dash(), dash(), dash(), dash()]);
        for t in &self.techniques {
            table.row([
                format!("`{}`", t.name),
                percent(t.wrong, 3),
                percent(t.worst_wrong, 3),
                t.worst_seconds.map_or_else(dash, |seconds| self.time(seconds)),
                percent(t.changes, 4),
                percent(t.excess, 4),
                percent(t.steady_excess, 4),
                percent(t.more_often, 3),
                figure(t.most_excess.map(f64::from), 0),
            ]);
        }
        let ends = [self.seconds.first(), self.seconds.last()];
        let [first, last] = ends.map(|seconds| seconds.map_or_else(dash, |seconds| self.time(*seconds)));
        let keys = self
            .keys
            .map_or_else(String::new, |keys| format!(" The sun path that techniques read has {keys} keys."));
        format!(
            "## While the sun moves\n\n{} steps from {first} to {last}, {} left out because the sun is below the horizon, \
            {} pixels compared.{keys} The camera stands still. Every step is compared with one ray per pixel. Wrong: the \
            mean over the steps, and the worst step. Changes: pixels that change between lit and dark from one step to the \
            next, per pixel and step. Excess: those beyond the changes of rays, summed over the pixels that change more often \
            than with rays. Of it steady: at pixels that never change with rays. Pixels: the share of the pixels that change more \
            often.\n\n{}\n",
            self.steps,
            self.nights,
            grouped(self.pixels),
            table.markdown()
        )
    }
}
