//! The sun's path by day, as directions close enough together to connect them.

use crate::day::Day;
use crate::error::Result;
use crate::location::Location;
use crate::position::{Atmosphere, Position, position};

/// Longest time between directions, seconds. In this time the sun's path bends by 0.02" from a straight one.
pub const ARC_STEP_SECONDS: f64 = 20.0;
/// Halvings of that time by which a rise or set is found: to a millisecond.
const HALVINGS: u32 = 15;

/// A span of time in which the centre of the sun is above some elevation.
#[derive(Clone, Debug, PartialEq)]
pub struct SunArc {
    /// Times, seconds after 1970, that rise by at most [`ARC_STEP_SECONDS`]. The first and the last are the
    /// span's ends.
    pub times: Vec<f64>,
    /// The unit vector towards the sun's centre at each of the times.
    pub towards: Vec<[f64; 3]>,
}

/// Returns the arcs of the sun between two times, in which its centre is above `least_elevation_degrees`.
/// Their ends are exact to a millisecond, where they are not those of the span. Cost: about 15 µs per minute.
///
/// # Errors
/// Returns the errors of [`position`].
pub fn sun_arcs(
    location: &Location,
    atmosphere: Option<&Atmosphere>,
    [from, to]: [f64; 2],
    least_elevation_degrees: f64,
) -> Result<Vec<SunArc>> {
    let at = |time: f64| position(location, time, atmosphere);
    let is_up = |position: &Position| position.elevation_degrees > least_elevation_degrees;
    let steps = ((to - from) / ARC_STEP_SECONDS).ceil() as u64;
    let mut arcs = Vec::new();
    let mut open: Option<SunArc> = None;
    let mut last: Option<(f64, bool)> = None;
    for step in 0..=steps {
        let time = (from + step as f64 * ARC_STEP_SECONDS).min(to);
        let now = at(time)?;
        let rises = is_up(&now);
        if let Some((before, was_up)) = last.filter(|(_, was_up)| *was_up != rises) {
            let (mut low, mut high) = (before, time);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if is_up(&at(middle)?) == was_up { low = middle } else { high = middle }
            }
            // The last or the first moment at which the sun is up.
            let edge = if was_up { low } else { high };
            let arc = open.get_or_insert_with(|| SunArc { times: Vec::new(), towards: Vec::new() });
            arc.push(edge, &at(edge)?);
            if was_up {
                arcs.extend(open.take());
            }
        }
        if rises {
            open.get_or_insert_with(|| SunArc { times: Vec::new(), towards: Vec::new() }).push(time, &now);
        }
        last = Some((time, rises));
    }
    arcs.extend(open);
    arcs.retain(|arc| arc.times.len() > 1);
    Ok(arcs)
}

impl SunArc {
    /// Adds a direction, unless its time is that of the one before.
    fn push(&mut self, time: f64, position: &Position) {
        if self.times.last().is_none_or(|last| *last < time) {
            self.times.push(time);
            self.towards.push(position.towards());
        }
    }
}

impl Day {
    /// Returns the arcs of the day in which the sun's centre is above the horizon, see [`sun_arcs`].
    ///
    /// # Errors
    /// Returns the errors of [`Day::ends`], and [`Error::Range`](crate::Error::Range) if the atmosphere is
    /// out of range.
    pub fn arcs(&self) -> Result<Vec<SunArc>> {
        let ends = self.ends()?.map(|time| time as f64);
        sun_arcs(&self.location, self.atmosphere.as_ref(), ends, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arcs(text: &str) -> Vec<SunArc> {
        format!("lat=48.14,lon=11.58,tz=Europe/Berlin,{text}").parse::<Day>().unwrap().arcs().unwrap()
    }

    #[test]
    fn arcs_end_at_rise_and_set() {
        let day = arcs("date=2026-03-20,from=0,to=24");
        let [arc] = &day[..] else { panic!("{} arcs", day.len()) };
        let hours = (arc.times[arc.times.len() - 1] - arc.times[0]) / 3600.0;
        assert!((12.0..12.3).contains(&hours), "{hours}");
        for end in [0, arc.times.len() - 1] {
            // The sun moves by 15" in a second.
            assert!((0.0..1e-6).contains(&arc.towards[end][1]), "{:?}", arc.towards[end]);
        }
        assert!(arc.times.windows(2).all(|w| w[0] < w[1] && w[1] - w[0] <= ARC_STEP_SECONDS));
        assert_eq!(arc.times.len(), arc.towards.len());
    }

    #[test]
    fn arcs_of_a_span_by_day_end_with_it() {
        let day = arcs("date=2026-06-21,from=7,to=19:00:30");
        let [arc] = &day[..] else { panic!("{} arcs", day.len()) };
        assert_eq!(
            (arc.times[0], arc.times[2160], arc.times[2162]),
            (1_782_018_000.0, 1_782_061_200.0, 1_782_061_230.0)
        );
        assert_eq!(arc.times.len(), 2163);
    }

    #[test]
    fn a_night_between_two_days_splits_them_and_a_night_has_none() {
        assert_eq!(arcs("date=2026-06-20,from=12,to=11").len(), 2);
        assert!(arcs("date=2026-06-20,from=23,to=2").is_empty());
        let pole = |date: &str| {
            let text = format!("lat=80,lon=20,date={date},from=0,to=24");
            text.parse::<Day>().unwrap().arcs().unwrap()
        };
        assert!(pole("2026-12-21").is_empty());
        assert_eq!(pole("2026-06-21")[0].times.len(), 4321);
    }
}
