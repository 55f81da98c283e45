//! Where the sun is.

use std::sync::atomic::Ordering;

use adumbra_solar::{Atmosphere, Location, Position, positions};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, ToPyArray};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::axes::axis;
use crate::pool::pool;
use crate::watch::watched;

type Numbers<'py> = Bound<'py, PyArray1<f64>>;

/// Returns the sun's azimuths, elevations, and elevations as seen through the air, in degrees, at seconds
/// after 1970.
#[pyfunction]
pub(crate) fn sun_angles<'py>(
    py: Python<'py>,
    place: (f64, f64, f64),
    times: PyReadonlyArray1<'py, f64>,
    refraction: bool,
) -> PyResult<(Numbers<'py>, Numbers<'py>, Numbers<'py>)> {
    let times = times.as_slice()?;
    let found: Vec<[f64; 3]> = watched(py, None, |watch| {
        let location = Location::new(place.0, place.1, place.2)?;
        let air = refraction.then_some(Atmosphere::STANDARD);
        let angles = |&time: &f64| {
            // Python is interrupted, and does not wait for the result.
            if watch.cancel.load(Ordering::Relaxed) {
                return Ok([0.0; 3]);
            }
            let [bare, seen] = positions(&location, time, [None, air.as_ref()])?;
            Ok([bare.azimuth_degrees, bare.elevation_degrees, seen.elevation_degrees])
        };
        pool(None)?.install(|| times.par_iter().map(angles).collect())
    })?;
    let [azimuths, elevations, apparent] =
        [0, 1, 2].map(|angle| found.iter().map(|angles| angles[angle]).collect::<Vec<_>>().into_pyarray(py));
    Ok((azimuths, elevations, apparent))
}

/// Returns unit vectors towards suns at these compass angles, in degrees, N × 3.
#[pyfunction]
pub(crate) fn sun_directions<'py>(
    py: Python<'py>,
    azimuths: PyReadonlyArray1<'py, f64>,
    elevations: PyReadonlyArray1<'py, f64>,
    up: &str,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let up = axis(up);
    let angles = azimuths.as_slice()?.iter().zip(elevations.as_slice()?);
    let directions: Vec<f64> = angles
        .flat_map(|(&azimuth_degrees, &elevation_degrees)| {
            up.to_file(Position { azimuth_degrees, elevation_degrees }.towards())
        })
        .collect();
    directions.to_pyarray(py).reshape([directions.len() / 3, 3])
}
