//! The sun as a directional light.

use super::vec3::normalize;
use crate::error::{Error, RangeError, RangeField, Result};

/// A directional light: the unit vector towards the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sun {
    towards: [f64; 3],
}

impl Sun {
    /// Creates a sun in the direction `towards`, which may have any length.
    ///
    /// # Errors
    /// Returns [`Error::SunDirection`] if the vector is zero or not finite, and [`Error::SunBelowHorizon`] if
    /// y <= 0.
    pub fn from_direction(towards: [f64; 3]) -> Result<Self> {
        let largest = towards.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        if !towards.iter().all(|c| c.is_finite()) || largest == 0.0 {
            return Err(Error::SunDirection { direction: towards });
        }
        let scaled = towards.map(|c| c / largest);
        let unit = normalize(scaled);
        if unit[1] <= 0.0 {
            let elevation_degrees = libm::asin(unit[1]).to_degrees();
            return Err(Error::SunBelowHorizon { elevation_degrees });
        }
        Ok(Self { towards: unit })
    }

    /// Creates the sun of a file with exactly these bits. [`Sun::from_direction`] would normalize the vector
    /// again and change the last bits.
    pub(crate) fn from_stored(towards: [f64; 3]) -> Self {
        Self { towards }
    }

    /// Creates a sun from compass angles: `azimuth_degrees` is clockwise from -Z as seen from above (90° is
    /// +X), and `elevation_degrees` is above the horizon.
    ///
    /// # Errors
    /// Returns [`Error::Range`] if an angle is not finite or the elevation is above 90°, and
    /// [`Error::SunBelowHorizon`] if the elevation is 0° or less.
    pub fn from_angles(azimuth_degrees: f64, elevation_degrees: f64) -> Result<Self> {
        if !azimuth_degrees.is_finite() || !elevation_degrees.is_finite() || elevation_degrees > 90.0 {
            return Err(RangeError::new(
                RangeField::SunElevation,
                format!("{elevation_degrees} (azimuth {azimuth_degrees})"),
                "above 0 and at most 90 degrees, with a finite azimuth",
            )
            .into());
        }
        if elevation_degrees <= 0.0 {
            return Err(Error::SunBelowHorizon { elevation_degrees });
        }
        let (azimuth, elevation) = (azimuth_degrees.to_radians(), elevation_degrees.to_radians());
        let flat = if elevation_degrees == 90.0 { 0.0 } else { libm::cos(elevation) };
        Self::from_direction([flat * libm::sin(azimuth), libm::sin(elevation), -flat * libm::cos(azimuth)])
    }

    /// Returns the unit vector towards the sun, in world space.
    pub fn towards(&self) -> [f64; 3] {
        self.towards
    }

    /// Returns the elevation above the horizon in degrees.
    pub fn elevation_degrees(&self) -> f64 {
        libm::asin(self.towards[1].min(1.0)).to_degrees()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        (0..3).all(|i| (a[i] - b[i]).abs() < 1e-12)
    }

    #[test]
    fn sun_angles_run_clockwise_from_minus_z() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        assert!(near(Sun::from_angles(0.0, 45.0).unwrap().towards(), [0.0, half, -half]));
        assert!(near(Sun::from_angles(90.0, 45.0).unwrap().towards(), [half, half, 0.0]));
        assert!(near(Sun::from_angles(-90.0, 45.0).unwrap().towards(), [-half, half, 0.0]));
        assert_eq!(Sun::from_angles(123.0, 90.0).unwrap().towards(), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn rejects_invalid_and_below_horizon_directions() {
        for direction in [[0.0; 3], [f64::NAN, 1.0, 0.0], [f64::INFINITY, 1.0, 0.0]] {
            assert!(
                matches!(Sun::from_direction(direction), Err(Error::SunDirection { .. })),
                "{direction:?}"
            );
        }
        for direction in [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]] {
            assert!(
                matches!(Sun::from_direction(direction), Err(Error::SunBelowHorizon { .. })),
                "{direction:?}"
            );
        }
        assert!(matches!(Sun::from_angles(0.0, -0.5), Err(Error::SunBelowHorizon { .. })));
        assert!(matches!(Sun::from_angles(0.0, 90.5), Err(Error::Range(_))));
        // Lengths do not matter, even those whose squares overflow or underflow.
        assert_eq!(Sun::from_direction([0.0, 1e-300, 0.0]).unwrap().towards(), [0.0, 1.0, 0.0]);
        assert_eq!(Sun::from_direction([0.0, 1e300, 0.0]).unwrap().towards(), [0.0, 1.0, 0.0]);
    }
}
