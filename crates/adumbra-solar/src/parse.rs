//! A day as text: keys and values between commas.

use std::str::FromStr;

use crate::day::Day;
use crate::error::{Error, Result};
use crate::location::Location;

/// The keys, in the order in which missing ones are named.
const KEYS: [&str; 9] = ["lat", "lon", "date", "from", "to", "tz", "step", "height", "refraction"];

impl FromStr for Day {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let mut values: [Option<&str>; KEYS.len()] = [None; KEYS.len()];
        for part in text.split(',') {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            let (key, value) = (key.trim(), value.trim());
            let Some(index) = KEYS.iter().position(|&known| known == key) else {
                return Err(Error::UnknownKey { key: key.to_owned(), text: text.to_owned() });
            };
            if values[index].replace(value).is_some() {
                return Err(Error::Twice { key: KEYS[index], text: text.to_owned() });
            }
        }
        let [lat, lon, date, from, to, zone, step, height, refraction] = values;
        let missing = |key| Error::Missing { key, text: text.to_owned() };
        let needed =
            |key: &'static str, value: Option<&str>| value.map(str::to_owned).ok_or_else(|| missing(key));
        let degrees = |key, value| number(key, &needed(key, value)?, "degrees, such as 48.14");
        let metres = height.map_or(Ok(0.0), |value| number("height", value, "metres, such as 520"))?;
        let location = Location::new(degrees("lat", lat)?, degrees("lon", lon)?, metres)?;
        let date = needed("date", date)?.parse()?;
        let mut day = Self::new(location, date, needed("from", from)?.parse()?, needed("to", to)?.parse()?);
        day.zone = zone.map(str::parse).transpose()?;
        if let Some(value) = step {
            day.step_seconds =
                value.parse().map_err(|_| wrong("step", value, "whole seconds, such as 60"))?;
        }
        match refraction {
            None | Some("on") => {}
            Some("off") => day.atmosphere = None,
            Some(other) => return Err(wrong("refraction", other, "on or off")),
        }
        Ok(day)
    }
}

fn number(field: &'static str, text: &str, expected: &'static str) -> Result<f64> {
    text.parse().map_err(|_| wrong(field, text, expected))
}

fn wrong(field: &'static str, text: &str, expected: &'static str) -> Error {
    Error::Text { field, text: text.to_owned(), expected }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: &str = "lat=48,lon=11,date=2026-06-21,from=7,to=19";

    #[test]
    fn parses_day_with_keys_in_any_order() {
        let all =
            format!("{WHOLE},tz=Europe/Berlin,step=30,height=520,refraction=off").parse::<Day>().unwrap();
        assert_eq!((all.step_seconds, all.atmosphere, all.location.height_m()), (30, None, 520.0));
        assert_eq!(all.zone.unwrap().name(), "Europe/Berlin");
        let turned = "to=19, from=7, date=2026-06-21, lon=11, lat=48".parse::<Day>().unwrap();
        assert_eq!(turned, WHOLE.parse().unwrap());
        assert_eq!((turned.step_seconds, turned.zone), (60, None));
    }

    #[test]
    fn rejects_invalid_days_with_reason() {
        for (text, message) in [
            ("", "there is no \"\""),
            ("lat=48", "lon is missing"),
            ("lat=48,lon=11,date=2026-06-21,from=7", "to is missing"),
            (&format!("{WHOLE},lat=2"), "lat is given twice"),
            (&format!("{WHOLE},zone=UTC"), "the keys are"),
            (&format!("{WHOLE},tz=Mars"), "no time zone \"Mars\""),
            (&format!("{WHOLE},step=x"), "whole seconds"),
            (&format!("{WHOLE},step=-5"), "whole seconds"),
            (&format!("{WHOLE},refraction=some"), "on or off"),
            ("lat=x,lon=11,date=2026-06-21,from=7,to=19", "lat \"x\" cannot be read"),
            ("lat=91,lon=11,date=2026-06-21,from=7,to=19", "latitude 91 is out of range"),
            ("lat=48,lon=11,date=2026-02-30,from=7,to=19", "2026-02-30"),
            ("lat=48,lon=11,date=2026-06-21,from=7h,to=19", "time \"7h\""),
        ] {
            let error = text.parse::<Day>().unwrap_err().to_string();
            assert!(error.contains(message), "{text}: {error}");
        }
    }
}
