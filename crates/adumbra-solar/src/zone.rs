//! Time zones: IANA names, fixed offsets, and the nautical zone of a place.

use std::str::FromStr;

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::{Offset, TimeZone};

use crate::error::{Error, Result};
use crate::location::Location;

/// A time zone, from the IANA database that is bundled with this crate.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    name: String,
    zone: TimeZone,
}

/// Longest offset from UTC, seconds.
const MOST_OFFSET_SECONDS: i32 = 18 * 3600;

impl Zone {
    /// The time zone of ships at sea: whole hours, the nearest to the place's longitude divided by 15. It has
    /// no summer time.
    pub fn nautical(location: &Location) -> Self {
        Self::from_offset((location.longitude_degrees() / 15.0).round() as i32 * 3600)
    }

    /// The name as it was given, or the offset.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How far the clock is ahead of UTC at `unix_seconds` after 1970, seconds.
    pub fn offset_seconds(&self, unix_seconds: f64) -> i32 {
        Timestamp::from_second(unix_seconds.floor() as i64)
            .map_or(0, |time| self.zone.to_offset(time).seconds())
    }

    /// The clock at `unix_seconds` after 1970: `07:30`, or `07:30:15` if it is not a whole minute. Times
    /// outside the calendar are shown as seconds.
    pub fn clock(&self, unix_seconds: f64) -> String {
        let Ok(time) = Timestamp::from_second(unix_seconds.floor() as i64) else {
            return format!("{unix_seconds} s");
        };
        let time = self.zone.to_datetime(time).time();
        let (hour, minute, second) = (time.hour(), time.minute(), time.second());
        if second == 0 {
            format!("{hour:02}:{minute:02}")
        } else {
            format!("{hour:02}:{minute:02}:{second:02}")
        }
    }

    /// The first instant at which the clock shows `civil`. A time that the clock skips is read as if the
    /// clock had not been put forward.
    pub(crate) fn first(&self, civil: DateTime) -> Option<i64> {
        self.zone.to_ambiguous_timestamp(civil).compatible().ok().map(Timestamp::as_second)
    }

    /// The last instant at which the clock shows `civil`. A time that the clock skips is read as by
    /// [`Zone::first`].
    pub(crate) fn last(&self, civil: DateTime) -> Option<i64> {
        self.zone.to_ambiguous_timestamp(civil).later().ok().map(Timestamp::as_second)
    }

    fn from_offset(seconds: i32) -> Self {
        let offset = Offset::from_seconds(seconds).unwrap_or(Offset::UTC);
        let (sign, minutes) = (if seconds < 0 { '-' } else { '+' }, seconds.abs() / 60);
        let name = format!("{sign}{:02}:{:02}", minutes / 60, minutes % 60);
        Self { name, zone: offset.to_time_zone() }
    }
}

impl FromStr for Zone {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let unknown = || Error::UnknownZone { name: text.to_owned() };
        if text == "Z" {
            return Ok(Self::from_offset(0));
        }
        if let Some(offset) = text.strip_prefix(['+', '-']) {
            let (hours, minutes) = offset.split_once(':').unwrap_or((offset, "00"));
            let number = |digits: &str| -> Option<i32> {
                let plain = matches!(digits.len(), 1 | 2) && digits.bytes().all(|b| b.is_ascii_digit());
                digits.parse().ok().filter(|_| plain)
            };
            let hours = number(hours).ok_or_else(unknown)?;
            let minutes = number(minutes).filter(|&m| m < 60).ok_or_else(unknown)?;
            let seconds = hours * 3600 + minutes * 60;
            if seconds > MOST_OFFSET_SECONDS {
                return Err(unknown());
            }
            return Ok(Self::from_offset(if text.starts_with('-') { -seconds } else { seconds }));
        }
        let zone = TimeZone::get(text).map_err(|_| unknown())?;
        Ok(Self { name: text.to_owned(), zone })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zones_are_read_from_names_and_offsets() {
        let noon = 1_782_043_200.0; // 2026-06-21T12:00Z
        for (name, clock) in [
            ("Europe/Berlin", "14:00"),
            ("Asia/Kathmandu", "17:45"),
            ("UTC", "12:00"),
            ("Z", "12:00"),
            ("+02:00", "14:00"),
            ("-3:30", "08:30"),
            ("+9", "21:00"),
        ] {
            assert_eq!(name.parse::<Zone>().unwrap().clock(noon), clock, "{name}");
        }
        assert_eq!("UTC".parse::<Zone>().unwrap().clock(noon + 7.0), "12:00:07");
    }

    #[test]
    fn rejects_unknown_zones() {
        for name in ["", "Europe/Berln", "+", "+25", "+02:60", "+2:-1", "02:00", "+002:00"] {
            assert_eq!(name.parse::<Zone>(), Err(Error::UnknownZone { name: name.to_owned() }));
        }
    }

    #[test]
    fn nautical_zones_are_whole_hours() {
        let name = |longitude| Zone::nautical(&Location::new(0.0, longitude, 0.0).unwrap()).name().to_owned();
        assert_eq!(
            [0.0, 7.4, 7.6, -7.6, 180.0, -180.0].map(name),
            ["+00:00", "+00:00", "+01:00", "-01:00", "+12:00", "-12:00"]
        );
    }
}
