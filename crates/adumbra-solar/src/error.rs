//! Errors of places, times and lists of suns.

/// Any error of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number is out of its range.
    #[error("{field} {value} is out of range; give {expected}")]
    Range {
        /// The field.
        field: &'static str,
        /// Its value, as it was given.
        value: String,
        /// What is accepted.
        expected: &'static str,
    },
    /// A text is not what its field needs.
    #[error("{field} {text:?} cannot be read; give {expected}")]
    Text {
        /// The field.
        field: &'static str,
        /// The text.
        text: String,
        /// What is accepted.
        expected: &'static str,
    },
    /// A time zone is not known.
    #[error(
        "there is no time zone {name:?}; give an IANA name such as Europe/Berlin, or an offset such as +02:00"
    )]
    UnknownZone {
        /// The name.
        name: String,
    },
    /// A date is outside the range of the algorithm.
    #[error("the date {date} is out of range; give one of the years 1 to 2999")]
    DateRange {
        /// The date.
        date: String,
    },
    /// No time is between the two ends.
    #[error(
        "no time is between {from} and {to} on {date}; give an end after the start, 24 for the end of the day, or one before the start for the next day"
    )]
    EmptySpan {
        /// The date.
        date: String,
        /// The start by the clock.
        from: String,
        /// The end by the clock.
        to: String,
    },
    /// A key of a day's text is not known.
    #[error(
        "there is no {key:?} in {text:?}; the keys are lat, lon, height, date, from, to, tz, step and refraction"
    )]
    UnknownKey {
        /// The key.
        key: String,
        /// The whole text.
        text: String,
    },
    /// A key of a day's text is given twice.
    #[error("{key} is given twice in {text:?}; give it once")]
    Twice {
        /// The key.
        key: &'static str,
        /// The whole text.
        text: String,
    },
    /// A key of a day's text is missing.
    #[error("{key} is missing in {text:?}; give lat=48,lon=11,date=2026-06-21,from=7,to=19, for example")]
    Missing {
        /// The key.
        key: &'static str,
        /// The whole text.
        text: String,
    },
    /// A line of a list of suns cannot be read.
    #[error(
        "line {line}: {what}; give a time, an azimuth and an elevation, such as 2026-06-21T07:00:00+02:00 77.5 13.2"
    )]
    Line {
        /// Its number, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// A list holds no sun.
    #[error("there is no sun in the list; give a time, an azimuth and an elevation on each line")]
    EmptyList,
}

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Checks that a number is within limits that it may reach.
pub(crate) fn check(
    field: &'static str,
    value: f64,
    [least, most]: [f64; 2],
    expected: &'static str,
) -> Result<()> {
    if value >= least && value <= most {
        return Ok(());
    }
    Err(Error::Range { field, value: value.to_string(), expected })
}
