//! Errors of points, days and skies.

/// Any error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A value is out of its range.
    #[error("{field} {value} is out of range; give {expected}")]
    Range {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
        /// What is accepted.
        expected: &'static str,
    },
    /// A line of a table of points cannot be read.
    #[error("line {line}: {what}; give x,y,z or x,y,z,nx,ny,nz")]
    Line {
        /// Its number, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// There is no point.
    #[error("there is no point {place}; {advice}")]
    NoPoints {
        /// Where points were looked for.
        place: &'static str,
        /// What to do.
        advice: &'static str,
    },
    /// There would be too many points.
    #[error(
        "a spacing of {spacing_world} gives about {points} points, more than {most}; give a larger spacing"
    )]
    TooManyPoints {
        /// The spacing, world units.
        spacing_world: f64,
        /// About how many points it gives.
        points: f64,
        /// How many there may be.
        most: u64,
    },
    /// The work was cancelled.
    #[error("interrupted; nothing was written")]
    Interrupted,
}

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;
