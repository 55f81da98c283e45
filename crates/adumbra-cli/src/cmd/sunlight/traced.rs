//! The results of tracing: points, their hours and the clock, as outputs need them.

use adumbra_solar::{Day, Zone};
use adumbra_sunlight::{Grid, Hours, Receiver};

use super::study::Points;

/// The hours of a scene's points.
pub(super) struct Traced {
    pub(super) points: Points,
    pub(super) hours: Hours,
    pub(super) day: Day,
    pub(super) zone: Zone,
    /// How long the sun is above the horizon, hours.
    pub(super) most_hours: f64,
}

/// Seconds of an hour.
pub(super) const HOUR_SECONDS: f64 = 3600.0;

impl Traced {
    /// The points, each with its number.
    pub(super) fn receivers(&self) -> impl Iterator<Item = (usize, &Receiver)> {
        self.points.receivers.iter().enumerate()
    }

    /// How long a point is lit, hours.
    pub(super) fn hours_of(&self, point: usize) -> f64 {
        self.hours.seconds(point) / HOUR_SECONDS
    }

    /// The spans in which a point is lit, by the clock, to the nearest second.
    pub(super) fn clock_spans(&self, point: usize) -> Vec<[String; 2]> {
        self.hours.spans(point).iter().map(|span| span.map(|time| self.zone.clock(time.round()))).collect()
    }

    /// Mean, least and most hours.
    pub(super) fn spread(&self) -> [f64; 3] {
        let all = || (0..self.hours.len()).map(|point| self.hours_of(point));
        let mean = all().sum::<f64>() / self.hours.len().max(1) as f64;
        [mean, all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max)]
    }

    /// The hours of each cell of the grid, row by row; `None` for cells without a point.
    pub(super) fn cells(&self) -> Option<(&Grid, Vec<Option<f64>>)> {
        let (grid, cells) = self.points.grid.as_ref()?;
        let mut hours = vec![None; grid.cells()];
        for (point, &cell) in cells.iter().enumerate() {
            hours[cell as usize] = Some(self.hours_of(point));
        }
        Some((grid, hours))
    }

    /// The date, the span and the zone, in a line.
    pub(super) fn when(&self) -> String {
        format!("{} {} to {} {}", self.day.date, self.day.from, self.day.to, self.zone.name())
    }
}
