//! Moments of sun paths.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::str::FromStr;

use adumbra::file::fields::is_path;
use adumbra::{IoError, ShadowFile, Sun, SunPath, SunStep};
use adumbra_solar::{Clock, Day};

use crate::exit::Failure;
use crate::memory::MemoryLimit;

/// A moment of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeArg {
    /// By the path's local clock: the first time that it shows this many seconds after midnight.
    Clock(u32),
    /// As the path counts seconds.
    Seconds(f64),
}

impl FromStr for TimeArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.contains(':') {
            let clock: Clock = text.parse().map_err(|error: adumbra_solar::Error| error.to_string())?;
            return Ok(Self::Clock(clock.seconds()));
        }
        match text.parse() {
            Ok(seconds) if f64::is_finite(seconds) => Ok(Self::Seconds(seconds)),
            _ => Err("give a time by the clock, such as 12:30, or seconds".to_owned()),
        }
    }
}

/// Opens the sun path at `path`. `None` if the file is not one.
///
/// # Errors
///
/// Returns [`Failure`] if the file cannot be read, or is a path that is not valid.
pub fn sun_path(path: &Path) -> Result<Option<SunPath>, Failure> {
    let mut first = [0; 8];
    let read = File::open(path).and_then(|mut file| file.read(&mut first));
    let length = read.map_err(IoError::at("read", path))?;
    if is_path(&first[..length]) { Ok(Some(SunPath::read(path)?)) } else { Ok(None) }
}

/// The suns of a day: its steps, and how far its clock is ahead of UTC at the first one.
///
/// # Errors
///
/// Returns an error if the day has no such hours.
pub fn suns_of_day(day: &Day) -> adumbra_solar::Result<(Vec<SunStep>, i32)> {
    let steps = steps_of(&day.steps()?);
    let first = steps.first().map_or(0.0, |step| step.seconds);
    Ok((steps, day.zone().offset_seconds(first)))
}

/// Returns steps as a path has them.
pub fn steps_of(steps: &[adumbra_solar::SunStep]) -> Vec<SunStep> {
    let step = |step: &adumbra_solar::SunStep| SunStep {
        seconds: step.unix_seconds,
        towards_sun: step.position.towards(),
    };
    steps.iter().map(step).collect()
}

/// Returns a moment as a clock shows it, or in seconds if the path has no clock.
pub fn clock(seconds: f64, utc_offset_seconds: i32, has_clock: bool) -> String {
    if !has_clock {
        return format!("{seconds} s");
    }
    let of_day = (seconds + f64::from(utc_offset_seconds)).rem_euclid(86_400.0) as u32;
    let [hours, minutes, seconds] = [of_day / 3600, of_day / 60 % 60, of_day % 60];
    if seconds == 0 {
        format!("{hours:02}:{minutes:02}")
    } else {
        format!("{hours:02}:{minutes:02}:{seconds:02}")
    }
}

/// Returns a moment of a path as its clock shows it.
pub fn shown(path: &SunPath, seconds: f64) -> String {
    clock(seconds, path.utc_offset_seconds(), path.place_degrees().is_some())
}

/// Returns the first and the last moment of a path.
pub fn span(path: &SunPath) -> [f64; 2] {
    let steps = path.steps();
    [0, steps.len() - 1].map(|i| steps[i].seconds)
}

/// Returns the seconds of a moment that was given with an option.
///
/// # Errors
///
/// Returns [`Failure::Usage`] if the path does not have it.
pub fn moment(path: &SunPath, option: &str, time: TimeArg) -> Result<f64, Failure> {
    let [first, last] = span(path);
    let seconds = match time {
        TimeArg::Seconds(seconds) => seconds,
        TimeArg::Clock(of_day) => {
            if path.place_degrees().is_none() {
                return Err(Failure::Usage(format!("{option}: the path is of listed suns; give seconds")));
            }
            let offset = f64::from(path.utc_offset_seconds());
            let midnight = ((first + offset) / 86_400.0).floor() * 86_400.0 - offset;
            let seconds = midnight + f64::from(of_day);
            if seconds < first { seconds + 86_400.0 } else { seconds }
        }
    };
    if (first..=last).contains(&seconds) {
        return Ok(seconds);
    }
    let [first, last] = [first, last].map(|seconds| shown(path, seconds));
    Err(Failure::Usage(format!("{option}: the path is from {first} to {last}")))
}

/// The sun of a moment, and the keys around it.
pub struct PathMoment {
    /// The sun.
    pub sun: Sun,
    /// The files of the keys: the key to march in first, and the other.
    pub keys: [ShadowFile; 2],
}

/// Reads what answers at a moment. `None` at night.
///
/// # Errors
///
/// Returns [`Failure`] if a key cannot be read or does not fit into the limit.
pub fn path_moment(path: &SunPath, seconds: f64, limit: MemoryLimit) -> Result<Option<PathMoment>, Failure> {
    let (Some(towards), Some([first, second])) = (path.sun_at(seconds), path.keys_at(seconds)) else {
        return Ok(None);
    };
    let sun = Sun::from_direction(towards)?;
    let first_file = limit.read_key(path, first)?;
    let second_file = if second == first { first_file.clone() } else { limit.read_key(path, second)? };
    Ok(Some(PathMoment { sun, keys: [first_file, second_file] }))
}
