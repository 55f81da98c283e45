//! Suns as text, one on a line.

use jiff::Timestamp;

use crate::day::SunStep;
use crate::error::{Error, Result};
use crate::position::Position;

/// Reads suns from text: on each line a time, an azimuth in degrees clockwise from north, and an elevation in
/// degrees, separated by spaces, tabs or commas. A time is RFC 3339 with an offset, such as
/// `2026-06-21T07:00:00+02:00`, or seconds after 1970. Times ascend. Empty lines, and text after `#`, are
/// skipped. A sun at the horizon or below is a step without a light.
///
/// # Errors
/// Returns [`Error::Line`] for the first line that cannot be read, or whose time is not after the one before
/// it, and [`Error::EmptyList`] if there is no sun.
pub fn read_suns(text: &str) -> Result<Vec<SunStep>> {
    let mut steps: Vec<SunStep> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let wrong = |what: String| Error::Line { line: index + 1, what };
        let content = line.split('#').next().unwrap_or_default();
        let words: Vec<&str> = content.split([' ', '\t', ',']).filter(|word| !word.is_empty()).collect();
        let (time, azimuth, elevation) = match words[..] {
            [] => continue,
            [time, azimuth, elevation] => (time, azimuth, elevation),
            _ => return Err(wrong(format!("{} words, but there should be 3", words.len()))),
        };
        let time = seconds(time).ok_or_else(|| {
            wrong(format!("{time:?} is neither a time with an offset nor seconds after 1970"))
        })?;
        let degrees = |name: &str, word: &str, most: f64| {
            let number = word.parse::<f64>().ok().filter(|n| n.abs() <= most);
            number.ok_or_else(|| wrong(format!("the {name} {word:?} is not from -{most} to {most} degrees")))
        };
        let position = Position {
            azimuth_degrees: degrees("azimuth", azimuth, 360.0)?,
            elevation_degrees: degrees("elevation", elevation, 90.0)?,
        };
        if steps.last().is_some_and(|last| last.unix_seconds >= time) {
            return Err(wrong("the time is not after that of the sun before it".to_owned()));
        }
        steps.push(SunStep::new(time, position));
    }
    if steps.is_empty() { Err(Error::EmptyList) } else { Ok(steps) }
}

fn seconds(word: &str) -> Option<f64> {
    let number = word.parse::<f64>().ok().filter(|n| n.is_finite());
    number.or_else(|| word.parse::<Timestamp>().ok().map(|time| time.as_nanosecond() as f64 * 1e-9))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_suns_with_rfc_3339_times_and_seconds() {
        let text = "# a day\n2026-06-21T07:00:00+02:00 77.5 13.2\n\n1782021600, 88.1,\t22.9 # an hour later\r\n\
                    2026-06-21T22:00:00.5Z -30 -2";
        let steps = read_suns(text).unwrap();
        let times: Vec<f64> = steps.iter().map(|step| step.unix_seconds).collect();
        assert_eq!(times, [1_782_018_000.0, 1_782_021_600.0, 1_782_079_200.5]);
        assert_eq!(steps[1].position, Position { azimuth_degrees: 88.1, elevation_degrees: 22.9 });
        assert_eq!(steps.iter().map(|step| step.sun.is_some()).collect::<Vec<_>>(), [true, true, false]);
    }

    #[test]
    fn rejects_invalid_suns_with_line_number() {
        for (text, message) in [
            ("0 0 10\n1 0", "line 2: 2 words"),
            ("0 0 10 5", "line 1: 4 words"),
            ("\nyesterday 0 10", "line 2: \"yesterday\""),
            ("2026-06-21T07:00:00 0 10", "line 1: \"2026-06-21T07:00:00\" is neither"),
            ("0 400 10", "line 1: the azimuth \"400\""),
            ("0 0 91", "line 1: the elevation \"91\""),
            ("0 NaN 10", "line 1: the azimuth \"NaN\""),
            ("5 0 10\n5 0 11", "line 2: the time is not after"),
            ("# nothing\n", "no sun in the list"),
        ] {
            let error = read_suns(text).unwrap_err().to_string();
            assert!(error.contains(message), "{text}: {error}");
        }
    }
}
