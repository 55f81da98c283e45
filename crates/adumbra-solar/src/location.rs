//! A place on Earth.

use crate::error::{Result, check};

/// A location on Earth, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Location {
    latitude_degrees: f64,
    longitude_degrees: f64,
    height_m: f64,
}

impl Location {
    /// Creates a location from its latitude (-90 to 90 degrees, north is positive), its longitude (-180 to
    /// 180 degrees, east is positive) and its height above the sea (-500 to 9000 m). Height affects only the
    /// sun's parallax, by far less than 0.001°; it neither lowers the horizon nor thins the air.
    ///
    /// # Errors
    /// Returns [`Error::Range`](crate::Error::Range) if a number is out of its range or not a number.
    pub fn new(latitude_degrees: f64, longitude_degrees: f64, height_m: f64) -> Result<Self> {
        check("latitude", latitude_degrees, [-90.0, 90.0], "-90 to 90 degrees, positive in the north")?;
        check("longitude", longitude_degrees, [-180.0, 180.0], "-180 to 180 degrees, positive in the east")?;
        check("height", height_m, [-500.0, 9000.0], "-500 to 9000 metres above the sea")?;
        Ok(Self { latitude_degrees, longitude_degrees, height_m })
    }

    /// Degrees, positive in the north.
    pub fn latitude_degrees(&self) -> f64 {
        self.latitude_degrees
    }

    /// Degrees, positive in the east.
    pub fn longitude_degrees(&self) -> f64 {
        self.longitude_degrees
    }

    /// Metres above the sea.
    pub fn height_m(&self) -> f64 {
        self.height_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rejects_locations_out_of_range() {
        assert!(Location::new(90.0, -180.0, 0.0).is_ok() && Location::new(-90.0, 180.0, 8849.0).is_ok());
        for (latitude, longitude, height) in
            [(90.1, 0.0, 0.0), (f64::NAN, 0.0, 0.0), (0.0, 181.0, 0.0), (0.0, 0.0, f64::INFINITY)]
        {
            let error = Location::new(latitude, longitude, height).unwrap_err().to_string();
            assert!(error.contains("out of range; give -"), "{error}");
        }
    }
}
