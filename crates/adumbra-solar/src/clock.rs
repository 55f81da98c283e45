//! Dates and times of day, as people write them.

use std::fmt;
use std::str::FromStr;

use jiff::civil;

use crate::error::{Error, Result};
use crate::position::YEARS;

/// A day of the Gregorian calendar, which is also used for the centuries before its introduction. As text:
/// `2026-06-21`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Date(civil::Date);

impl Date {
    /// Creates a date from its year (1 to 2999), month (1 to 12) and day of the month (from 1).
    ///
    /// # Errors
    /// Returns [`Error::DateRange`] if there is no such day.
    pub fn new(year: i16, month: i8, day: i8) -> Result<Self> {
        civil::Date::new(year, month, day)
            .ok()
            .filter(|_| (YEARS[0]..=YEARS[1]).contains(&year))
            .map(Self)
            .ok_or_else(|| Error::DateRange { date: format!("{year:04}-{month:02}-{day:02}") })
    }

    /// Returns this time of the clock on this day, or on the next one.
    pub(crate) fn at(self, time: Clock, next: bool) -> Option<civil::DateTime> {
        let days = u32::from(next) + time.0 / DAY_SECONDS;
        let seconds = time.0 % DAY_SECONDS;
        let date = (0..days).try_fold(self.0, |date, _| date.tomorrow().ok())?;
        let [hour, minute, second] = [seconds / 3600, seconds / 60 % 60, seconds % 60].map(|n| n as i8);
        Some(date.at(hour, minute, second, 0))
    }
}

impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl FromStr for Date {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let wrong =
            || Error::Text { field: "date", text: text.to_owned(), expected: "one such as 2026-06-21" };
        let parts: Vec<&str> = text.split('-').collect();
        let &[year, month, day] = &parts[..] else { return Err(wrong()) };
        let digits = |part: &str, count: usize| {
            (part.len() == count && part.bytes().all(|b| b.is_ascii_digit())).then_some(())
        };
        digits(year, 4).and_then(|()| digits(month, 2)).and_then(|()| digits(day, 2)).ok_or_else(wrong)?;
        let number = |part: &str| part.parse::<i16>().map_err(|_| wrong());
        Self::new(number(year)?, number(month)? as i8, number(day)? as i8)
    }
}

/// A time of day by the local clock, from 0:00 to 24:00. As text: `7`, `07:30` or `07:30:15`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Clock(u32);

pub(crate) const DAY_SECONDS: u32 = 86_400;

impl Clock {
    /// Creates a time from the hours, minutes and seconds that a clock shows; 24:00:00 is the end of the day.
    ///
    /// # Errors
    /// Returns [`Error::Text`] if no clock shows it.
    pub fn new(hour: u32, minute: u32, second: u32) -> Result<Self> {
        let within = hour <= 24 && minute < 60 && second < 60;
        let seconds = if within { hour * 3600 + minute * 60 + second } else { u32::MAX };
        if seconds <= DAY_SECONDS {
            return Ok(Self(seconds));
        }
        let text = format!("{hour}:{minute:02}:{second:02}");
        Err(Error::Text { field: "time", text, expected: "a time from 0:00 to 24:00" })
    }

    /// Seconds since midnight, by the clock.
    pub fn seconds(self) -> u32 {
        self.0
    }
}

impl fmt::Display for Clock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [hour, minute, second] = [self.0 / 3600, self.0 / 60 % 60, self.0 % 60];
        write!(f, "{hour:02}:{minute:02}")?;
        if second == 0 { Ok(()) } else { write!(f, ":{second:02}") }
    }
}

impl FromStr for Clock {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let expected = "a time such as 7, 07:30 or 24";
        let wrong = || Error::Text { field: "time", text: text.to_owned(), expected };
        let mut numbers = [0; 3];
        let parts: Vec<&str> = text.split(':').collect();
        if parts.len() > numbers.len() {
            return Err(wrong());
        }
        for (index, (part, number)) in parts.iter().zip(&mut numbers).enumerate() {
            let length = if index == 0 { 1..=2 } else { 2..=2 };
            if !length.contains(&part.len()) || !part.bytes().all(|b| b.is_ascii_digit()) {
                return Err(wrong());
            }
            *number = part.parse().map_err(|_| wrong())?;
        }
        let [hour, minute, second] = numbers;
        Self::new(hour, minute, second).map_err(|_| wrong())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_and_displays_clock_times_and_rejects_invalid_ones() {
        for (text, shown) in
            [("7", "07:00"), ("07:30", "07:30"), ("0:05", "00:05"), ("23:59:59", "23:59:59"), ("24", "24:00")]
        {
            assert_eq!(text.parse::<Clock>().unwrap().to_string(), shown);
        }
        for text in ["", "25", "7:5", "7:60", "24:01", "-1", "7:30:15:1", "7.5", "+7", "007"] {
            assert!(matches!(text.parse::<Clock>(), Err(Error::Text { .. })), "{text}");
        }
    }

    #[test]
    fn rejects_dates_that_do_not_exist() {
        assert_eq!("2024-02-29".parse::<Date>().unwrap().to_string(), "2024-02-29");
        assert!("0001-01-01".parse::<Date>().is_ok() && "2999-12-31".parse::<Date>().is_ok());
        for text in ["2026-02-29", "0000-01-01", "3000-01-01", "2026-13-01", "2026-00-10"] {
            assert!(matches!(text.parse::<Date>(), Err(Error::DateRange { .. })), "{text}");
        }
        for text in ["", "2026", "2026-6-21", "21.06.2026", "2026-06-21T00", "-2026-06-21"] {
            assert!(matches!(text.parse::<Date>(), Err(Error::Text { .. })), "{text}");
        }
    }
}
