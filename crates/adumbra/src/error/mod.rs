//! Errors of reading a file and of setting up a look-up.

mod field;
mod format;

use std::fmt::Display;
use std::path::{Path, PathBuf};

pub use field::RangeField;
pub use format::FormatError;

/// Any error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system failed to read a file.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A shadow file is not valid.
    #[error("{}{source}", named(path.as_deref()))]
    Format {
        /// The file; `None` for bytes that have no path.
        path: Option<PathBuf>,
        /// The fault in the file.
        source: Box<FormatError>,
    },
    /// The sun's direction has zero length or is not finite.
    #[error(
        "the sun's direction ({0}, {1}, {2}) is not a direction; give three finite numbers, not all zero, that point towards the sun",
        direction[0], direction[1], direction[2]
    )]
    SunDirection {
        /// The direction that was given.
        direction: [f64; 3],
    },
    /// The sun is at or below the horizon.
    #[error(
        "the sun is {elevation_degrees:.3}° above the horizon; it casts no shadows from below: give a direction with positive y, or an elevation above 0"
    )]
    SunBelowHorizon {
        /// Elevation in degrees, zero or negative.
        elevation_degrees: f64,
    },
    /// A manifest of regions is not valid, or does not fit its files.
    #[error("{path:?} is not a manifest of regions that can be used: {what}", path = path.display())]
    Manifest {
        /// The manifest.
        path: PathBuf,
        /// What is wrong, as a clause.
        what: String,
    },
    /// A value is out of range.
    #[error(transparent)]
    Range(#[from] RangeError),
}

impl Error {
    /// Returns the error for a fault of the file at `path`.
    pub(crate) fn in_file(path: &Path, fault: FormatError) -> Self {
        Self::Format { path: Some(path.to_owned()), source: Box::new(fault) }
    }
}

impl From<FormatError> for Error {
    fn from(error: FormatError) -> Self {
        Self::Format { path: None, source: Box::new(error) }
    }
}

/// Returns the beginning of a message about a file.
fn named(path: Option<&Path>) -> String {
    path.map_or_else(String::new, |path| format!("{:?}: ", path.display()))
}

/// Result type of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// A value that is out of range. `F` is a crate's enum of fields.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {value} is out of range; it must be {range}")]
#[non_exhaustive]
pub struct RangeError<F = RangeField> {
    /// The field or parameter that has the value.
    pub field: F,
    /// The value that was given.
    pub value: String,
    /// The allowed range, as text.
    pub range: &'static str,
}

impl<F> RangeError<F> {
    /// Returns the error for `field` having the value `value`, which is not within `range`.
    pub fn new(field: F, value: impl Display, range: &'static str) -> Self {
        Self { field, value: shortened(&value.to_string()), range }
    }
}

/// Longest number in an error, in digits. A greater one, such as 1e300 in full, is written with an exponent.
const MOST_DIGITS: usize = 24;

/// Returns a text with short numbers.
fn shortened(text: &str) -> String {
    let is_of_number = |c: char| c.is_ascii_digit() || c == '.';
    let mut rest = text;
    let mut all = String::new();
    while let Some(start) = rest.find(is_of_number) {
        let (before, from_number) = rest.split_at(start);
        let end = from_number.find(|c| !is_of_number(c)).unwrap_or(from_number.len());
        let (number, after) = from_number.split_at(end);
        all.push_str(before);
        match number.parse::<f64>() {
            Ok(value) if number.len() > MOST_DIGITS => all.push_str(&format!("{value:e}")),
            _ => all.push_str(number),
        }
        rest = after;
    }
    all + rest
}

/// The operating system failed to read or write a file or folder.
#[derive(Debug, thiserror::Error)]
#[error("cannot {action} {path:?}: {source}", path = path.display())]
pub struct IoError {
    /// The attempted operation: "read", "create", "write" …
    pub action: &'static str,
    /// The file or folder.
    pub path: PathBuf,
    /// The error of the operating system.
    pub source: std::io::Error,
}

impl IoError {
    /// Returns a function that wraps an error of the operating system with `action` and `path`. For use with
    /// `map_err`.
    pub fn at(action: &'static str, path: impl AsRef<Path>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.as_ref().to_owned();
        move |source| {
            let source = if action == "read" { with_reading_hint(source) } else { source };
            Self { action, path, source }
        }
    }
}

/// Adds a hint to the message of the operating system. The error kind is kept.
fn with_reading_hint(error: std::io::Error) -> std::io::Error {
    use std::io::ErrorKind;
    let hint = match error.kind() {
        ErrorKind::NotFound => "check the name and the folder it is in",
        ErrorKind::IsADirectory => "it is a folder; name a file in it",
        ErrorKind::NotADirectory => "a part of the path is a file, not a folder; check the path",
        ErrorKind::PermissionDenied => "change its permissions, or choose another file",
        _ => return error,
    };
    std::io::Error::new(error.kind(), format!("{error}; {hint}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn format_errors_name_the_file_if_there_is_one() {
        let fault = || FormatError::TrailingBytes { end: 4 };
        let bytes = Error::from(fault()).to_string();
        assert_eq!(bytes, fault().to_string());
        let file = Error::Format { path: Some("a.adumbra".into()), source: Box::new(fault()) };
        assert_eq!(file.to_string(), format!("\"a.adumbra\": {bytes}"));
    }

    #[test]
    fn shortened_text_writes_long_numbers_with_exponent() {
        let text = format!("{} (azimuth -{}), 1.5 and 200000", 1e300, 2.5e40);
        assert_eq!(shortened(&text), "1e300 (azimuth -2.5e40), 1.5 and 200000");
        assert_eq!(shortened(&format!("{}", 1e-300)), "1e-300");
        assert_eq!(shortened("no numbers"), "no numbers");
    }
}
