//! The suns of a day by the clock of a place.

use adumbra::Sun;

use crate::clock::{Clock, DAY_SECONDS, Date};
use crate::error::{Error, Result};
use crate::location::Location;
use crate::position::{Atmosphere, Position, position};
use crate::zone::Zone;

/// A span of a day at a place, by the local clock.
///
/// As text:
/// `lat=48,lon=11,date=2026-06-21,from=7,to=19[,tz=Europe/Berlin][,step=60][,height=520][,refraction=off]`.
/// Keys may have any order. `tz` is an IANA name or an offset, `step` is in seconds, `height` in metres above
/// the sea.
#[derive(Clone, Debug, PartialEq)]
pub struct Day {
    /// The place.
    pub location: Location,
    /// The date on which the span begins.
    pub date: Date,
    /// Start by the local clock, before 24:00. If the clock shows the time twice, this is the first.
    pub from: Clock,
    /// End by the local clock. If it is before the start, it is on the next day. If the clock shows the time
    /// twice, this is the second.
    pub to: Clock,
    /// Time zone of the clock. `None` is the nautical zone, [`Zone::nautical`], regardless of the legal time
    /// there.
    pub zone: Option<Zone>,
    /// Time between steps, 1 to 86,400 s.
    pub step_seconds: u32,
    /// The atmosphere that refracts light. `None` disables refraction.
    pub atmosphere: Option<Atmosphere>,
}

/// The sun at one time of a day or a list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunStep {
    /// Seconds after 1970-01-01T00:00Z, without leap seconds.
    pub unix_seconds: f64,
    /// The sun's position.
    pub position: Position,
    /// The directional light; `None` if the sun is at the horizon or below.
    pub sun: Option<Sun>,
}

impl SunStep {
    /// Creates the step of a position.
    pub fn new(unix_seconds: f64, position: Position) -> Self {
        Self { unix_seconds, position, sun: position.sun() }
    }
}

impl Day {
    /// Default time between steps, in seconds.
    pub const DEFAULT_STEP_SECONDS: u32 = 60;

    /// Creates a span in steps of a minute, in the nautical zone, under the standard atmosphere.
    pub fn new(location: Location, date: Date, from: Clock, to: Clock) -> Self {
        Self {
            location,
            date,
            from,
            to,
            zone: None,
            step_seconds: Self::DEFAULT_STEP_SECONDS,
            atmosphere: Some(Atmosphere::STANDARD),
        }
    }

    /// The zone of the clock: the one that was given, or the nautical one.
    pub fn zone(&self) -> Zone {
        self.zone.clone().unwrap_or_else(|| Zone::nautical(&self.location))
    }

    /// Returns the first and the last instant, seconds after 1970. A time that the clock skips is read as if
    /// the clock had not been put forward, so a span over a skipped hour is an hour shorter than by the
    /// clock, and one over a repeated hour an hour longer.
    ///
    /// # Errors
    /// Returns [`Error::EmptySpan`] if the end is not after the start, and [`Error::Range`] if the start is
    /// 24:00.
    pub fn ends(&self) -> Result<[i64; 2]> {
        let empty = || Error::EmptySpan {
            date: self.date.to_string(),
            from: self.from.to_string(),
            to: self.to.to_string(),
        };
        if self.from >= Clock::new(24, 0, 0)? {
            let value = self.from.to_string();
            return Err(Error::Range { field: "start", value, expected: "a time before 24:00" });
        }
        let zone = self.zone();
        let out_of_range = || Error::DateRange { date: self.date.to_string() };
        let from = self.date.at(self.from, false).and_then(|civil| zone.first(civil));
        let to = self.date.at(self.to, self.to < self.from).and_then(|civil| zone.last(civil));
        let ends = [from.ok_or_else(out_of_range)?, to.ok_or_else(out_of_range)?];
        // Equal times are an hour apart if the clock shows them twice. Refuse that hour too: equal times are
        // almost certainly a mistake.
        if self.from == self.to || ends[0] >= ends[1] { Err(empty()) } else { Ok(ends) }
    }

    /// Returns the sun at the start, after each step, and at the end. The last step is shorter if the span is
    /// not a whole number of steps. Cost: about 5 µs a step.
    ///
    /// # Errors
    /// Returns the errors of [`Day::ends`], and [`Error::Range`] if the step or the atmosphere is out of
    /// range.
    pub fn steps(&self) -> Result<Vec<SunStep>> {
        if !(1..=DAY_SECONDS).contains(&self.step_seconds) {
            let value = self.step_seconds.to_string();
            return Err(Error::Range { field: "step", value, expected: "1 to 86400 seconds" });
        }
        let [from, to] = self.ends()?;
        let times = (from..to).step_by(self.step_seconds as usize).chain([to]);
        let step = |time: i64| {
            let seconds = time as f64;
            Ok(SunStep::new(seconds, position(&self.location, seconds, self.atmosphere.as_ref())?))
        };
        times.map(step).collect()
    }
}

#[cfg(test)]
mod tests;
