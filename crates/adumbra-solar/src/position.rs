//! The sun's position in the sky: NREL/TP-560-34302.

use adumbra::Sun;
use jiff::{Timestamp, tz::Offset};
use solar_positioning::time::JulianDate;
use solar_positioning::{RefractionCorrection, SolarPositions, delta_t};

use crate::error::{Error, Result, check};
use crate::location::Location;

/// The atmosphere, which refracts light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Atmosphere {
    /// Pressure at the place, hPa, above 0 and at most 2000.
    pub pressure_hpa: f64,
    /// Temperature at the place, °C, -100 to 100.
    pub temperature_celsius: f64,
}

impl Atmosphere {
    /// The standard atmosphere at the sea: 1013.25 hPa, 15 °C.
    pub const STANDARD: Self = Self { pressure_hpa: 1013.25, temperature_celsius: 15.0 };

    fn correction(&self) -> Result<RefractionCorrection> {
        check("pressure", self.pressure_hpa, [f64::MIN_POSITIVE, 2000.0], "above 0 and at most 2000 hPa")?;
        check("temperature", self.temperature_celsius, [-100.0, 100.0], "-100 to 100 °C")?;
        RefractionCorrection::new(self.pressure_hpa, self.temperature_celsius).map_err(|_| Error::Range {
            field: "pressure",
            value: self.pressure_hpa.to_string(),
            expected: "above 0 and at most 2000 hPa",
        })
    }
}

/// The position of the sun's centre in the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// Degrees clockwise from north, 0 to 360. At a pole it is measured from the place's own meridian.
    pub azimuth_degrees: f64,
    /// Degrees above the horizon, -90 to 90.
    pub elevation_degrees: f64,
}

impl Position {
    /// Returns the directional light, or `None` if the sun's centre is at the horizon or below.
    pub fn sun(&self) -> Option<Sun> {
        Sun::from_angles(self.azimuth_degrees, self.elevation_degrees).ok()
    }

    /// Returns the unit vector towards the sun's centre; y is negative below the horizon.
    pub fn towards(&self) -> [f64; 3] {
        let (azimuth, elevation) = (self.azimuth_degrees.to_radians(), self.elevation_degrees.to_radians());
        let flat = if self.elevation_degrees == 90.0 { 0.0 } else { libm::cos(elevation) };
        [flat * libm::sin(azimuth), libm::sin(elevation), -flat * libm::cos(azimuth)]
    }
}

/// First and last year that are accepted.
pub(crate) const YEARS: [i16; 2] = [1, 2999];

/// Julian date of 1970-01-01T00:00Z.
const JULIAN_1970: f64 = 2_440_587.5;
/// Seconds of a day.
const DAY_SECONDS: f64 = 86_400.0;

/// Returns the sun's position at a place, at `unix_seconds` after 1970-01-01T00:00Z. Without an atmosphere,
/// light is not refracted. UTC is used for UT1; the difference is less than a second, or 0.004°. Cost: about
/// 5 µs.
///
/// # Errors
/// Returns [`Error::DateRange`] outside the years 1 to 2999, and [`Error::Range`] for an atmosphere out of
/// range.
pub fn position(location: &Location, unix_seconds: f64, atmosphere: Option<&Atmosphere>) -> Result<Position> {
    positions(location, unix_seconds, [atmosphere]).map(|[position]| position)
}

/// Returns what [`position`] does for each of some atmospheres, at the cost of one position.
///
/// # Errors
/// See [`position`].
pub fn positions<const N: usize>(
    location: &Location,
    unix_seconds: f64,
    atmospheres: [Option<&Atmosphere>; N],
) -> Result<[Position; N]> {
    let out_of_range = || Error::DateRange { date: format!("{unix_seconds} s after 1970") };
    let whole = Timestamp::from_second(unix_seconds.floor() as i64).map_err(|_| out_of_range())?;
    let date = Offset::UTC.to_datetime(whole).date();
    if !unix_seconds.is_finite() || date.year() < YEARS[0] || date.year() > YEARS[1] {
        return Err(out_of_range());
    }
    let delta_seconds =
        delta_t::estimate_from_date(date.year().into(), u32::from(date.month().unsigned_abs()))
            .map_err(|_| out_of_range())?;
    let julian = JulianDate::new(JULIAN_1970 + unix_seconds / DAY_SECONDS, delta_seconds)
        .map_err(|_| out_of_range())?;
    let on_map = solar_positioning::Location {
        latitude: location.latitude_degrees(),
        longitude: location.longitude_degrees(),
    };
    let prepared = SolarPositions::new().for_time_from_julian(julian).map_err(|_| out_of_range())?;
    let mut positions = [Position { azimuth_degrees: 0.0, elevation_degrees: 0.0 }; N];
    for (position, atmosphere) in positions.iter_mut().zip(atmospheres) {
        let correction = atmosphere.map(Atmosphere::correction).transpose()?;
        let found = prepared.at(on_map, location.height_m(), correction).map_err(|_| out_of_range())?;
        *position = Position { azimuth_degrees: found.azimuth(), elevation_degrees: found.elevation_angle() };
    }
    Ok(positions)
}

#[cfg(test)]
mod tests;
