//! Hours of sun, the visible sky, and where the sun is.

use std::sync::atomic::Ordering;

use adumbra_scene::UpAxis;
use adumbra_solar::{Atmosphere, Day, Location, Position, positions};
use adumbra_sunlight::points::Facing;
use adumbra_sunlight::{DayOptions, Patches, Receiver, SunDay, sky_views};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, ToPyArray};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::{GivenOrigins, Places, Rooms};
use crate::axes::axis;
use crate::errors::Failure;
use crate::pool::pool;
use crate::scene::Scene;
use crate::watch::watched;

/// Seconds of an hour.
const HOUR_SECONDS: f64 = 3600.0;

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

/// Returns the hours of each point; the point, start and end of each span in which one is lit, in seconds
/// after 1970; and the name of the clock's zone. `day` is text as the program's `--sun-path` takes it.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "the arrays of hours and spans")]
pub(crate) fn sun_hours<'py>(
    py: Python<'py>,
    scene: &Scene,
    origins: GivenOrigins<'py>,
    day: &str,
    every_step: bool,
    threads: Option<usize>,
    report: Option<Py<PyAny>>,
) -> PyResult<(Numbers<'py>, Bound<'py, PyArray1<i64>>, Numbers<'py>, Numbers<'py>, String)> {
    let receivers = receivers(&origins, scene.up())?;
    let day: Day = day.parse().map_err(Failure::from)?;
    let found = watched(py, report, |watch| {
        let options = if every_step { DayOptions { key_degrees: 0.0 } } else { DayOptions::default() };
        let suns = SunDay::new(&day.steps()?, options)?;
        let pool = pool(threads)?;
        let tracer = scene.tracer(&pool)?;
        Ok(pool.install(|| suns.hours(tracer, &receivers, watch))?)
    })?;
    let hours: Vec<f64> = (0..found.len()).map(|point| found.seconds(point) / HOUR_SECONDS).collect();
    let (mut points, mut starts, mut ends) = (Vec::new(), Vec::new(), Vec::new());
    for point in 0..found.len() {
        for [start, end] in found.spans(point) {
            points.push(point as i64);
            starts.push(start);
            ends.push(end);
        }
    }
    let zone = day.zone().name().to_owned();
    Ok((hours.to_pyarray(py), points.to_pyarray(py), starts.to_pyarray(py), ends.to_pyarray(py), zone))
}

/// Returns which patches of the sky each point sees, its sky view factor and its shade fraction.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "the three arrays of skies")]
pub(crate) fn sky<'py>(
    py: Python<'py>,
    scene: &Scene,
    origins: GivenOrigins<'py>,
    fine: bool,
    threads: Option<usize>,
    report: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyArray2<bool>>, Numbers<'py>, Numbers<'py>)> {
    let receivers = receivers(&origins, scene.up())?;
    let patches = if fine { Patches::reinhart_577() } else { Patches::tregenza() };
    let views = watched(py, report, |watch| {
        let pool = pool(threads)?;
        let tracer = scene.tracer(&pool)?;
        Ok(pool.install(|| sky_views(tracer, &receivers, &patches, watch))?)
    })?;
    let seen: Vec<bool> =
        views.iter().flat_map(|view| (0..patches.len()).map(|patch| view.sees(patch))).collect();
    let factors: Vec<f64> = views.iter().map(|view| view.sky_view_factor).collect();
    let shades: Vec<f64> = views.iter().map(|view| view.shade_fraction).collect();
    let seen = seen.to_pyarray(py).reshape([views.len(), patches.len()])?;
    Ok((seen, factors.to_pyarray(py), shades.to_pyarray(py)))
}

fn receivers((places, lift_world): &GivenOrigins<'_>, up: UpAxis) -> PyResult<Vec<Receiver>> {
    let places = Places::new(places, up)?.with_unit_normals()?;
    let mut rooms = Rooms::default();
    let (points, normals) = places.range(0..places.len(), &mut rooms);
    let receiver = |(number, &p_world): (usize, &[f64; 3])| {
        let facing = normals.map_or(Facing::Space, |normals| Facing::Front(normals[number]));
        Receiver { p_world, facing, lift_world: *lift_world }
    };
    Ok(points.iter().enumerate().map(receiver).collect())
}
