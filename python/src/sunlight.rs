//! Hours of sun, the visible sky, and where the sun is.

use adumbra_solar::{Atmosphere, Day, Location, position};
use adumbra_sunlight::points::Facing;
use adumbra_sunlight::{DayOptions, Patches, Receiver, SunDay, sky_views};
use adumbra_truth::trace::{TraceOptions, Tracer};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, ToPyArray};
use pyo3::prelude::*;

use crate::arrays::{Triples, TriplesArray};
use crate::errors::Failure;
use crate::pool::pool;
use crate::scene::Scene;
use crate::watch::watched;

/// Seconds of an hour.
const HOUR_SECONDS: f64 = 3600.0;

/// Points, their normals, and how far rays start above them.
type Places<'py> = (TriplesArray<'py>, Option<TriplesArray<'py>>, f64);

type Numbers<'py> = Bound<'py, PyArray1<f64>>;

/// Returns azimuths and elevations in degrees, and unit vectors towards the sun, at seconds after 1970.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "the three arrays of a position")]
pub(crate) fn sun_positions<'py>(
    py: Python<'py>,
    place: (f64, f64, f64),
    times: PyReadonlyArray1<'py, f64>,
    refraction: bool,
) -> PyResult<(Numbers<'py>, Numbers<'py>, Bound<'py, PyArray2<f64>>)> {
    let times = times.as_slice()?;
    let (azimuths, elevations, towards) = watched(py, None, |_| {
        let location = Location::new(place.0, place.1, place.2)?;
        let air = refraction.then_some(Atmosphere::STANDARD);
        let (mut azimuths, mut elevations, mut towards) = (Vec::new(), Vec::new(), Vec::new());
        for &time in times {
            let found = position(&location, time, air.as_ref())?;
            azimuths.push(found.azimuth_degrees);
            elevations.push(found.elevation_degrees);
            towards.extend(found.towards());
        }
        Ok((azimuths, elevations, towards))
    })?;
    let towards = towards.to_pyarray(py).reshape([times.len(), 3])?;
    Ok((azimuths.to_pyarray(py), elevations.to_pyarray(py), towards))
}

/// Returns the hours of each point; the point, start and end of each span in which one is lit, in seconds
/// after 1970; and the name of the clock's zone. `day` is text as the program's `--sun-path` takes it.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "the arrays of hours and spans")]
pub(crate) fn sun_hours<'py>(
    py: Python<'py>,
    scene: &Scene,
    places: Places<'py>,
    day: &str,
    every_step: bool,
    threads: Option<usize>,
    report: Option<Py<PyAny>>,
) -> PyResult<(Numbers<'py>, Bound<'py, PyArray1<i64>>, Numbers<'py>, Numbers<'py>, String)> {
    let receivers = receivers(&places)?;
    let day: Day = day.parse().map_err(Failure::from)?;
    let found = watched(py, report, |watch| {
        let options = if every_step { DayOptions { key_degrees: 0.0 } } else { DayOptions::default() };
        let suns = SunDay::new(&day.steps()?, options)?;
        Ok(pool(threads)?.install(|| suns.hours(&tracer(scene), &receivers, watch))?)
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
    places: Places<'py>,
    fine: bool,
    threads: Option<usize>,
    report: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyArray2<bool>>, Numbers<'py>, Numbers<'py>)> {
    let receivers = receivers(&places)?;
    let patches = if fine { Patches::reinhart_577() } else { Patches::tregenza() };
    let views = watched(py, report, |watch| {
        Ok(pool(threads)?.install(|| sky_views(&tracer(scene), &receivers, &patches, watch))?)
    })?;
    let seen: Vec<bool> =
        views.iter().flat_map(|view| (0..patches.len()).map(|patch| view.sees(patch))).collect();
    let factors: Vec<f64> = views.iter().map(|view| view.sky_view_factor).collect();
    let shades: Vec<f64> = views.iter().map(|view| view.shade_fraction).collect();
    let seen = seen.to_pyarray(py).reshape([views.len(), patches.len()])?;
    Ok((seen, factors.to_pyarray(py), shades.to_pyarray(py)))
}

fn tracer(scene: &Scene) -> Tracer<'_> {
    Tracer::build(&scene.scene, TraceOptions { ignore_alpha: scene.ignore_alpha })
}

fn receivers((points, normals, lift_world): &Places<'_>) -> PyResult<Vec<Receiver>> {
    let points = points.rows()?;
    let normals = normals.as_ref().map(TriplesArray::rows).transpose()?;
    if let Some(other) = normals.map(Triples::len).filter(|&n| n != points.len()) {
        let what = format!("normals: {other} rows for {} points; give one for each point", points.len());
        return Err(Failure::Value(what).into());
    }
    let (mut of_points, mut of_normals) = (Vec::new(), Vec::new());
    let normals = normals.map(|normals| normals.range(0..points.len(), &mut of_normals));
    let points = points.range(0..points.len(), &mut of_points);
    let receiver = |(number, &p_world): (usize, &[f64; 3])| {
        let facing = normals.map_or(Facing::Space, |normals| Facing::Front(normals[number]));
        Receiver { p_world, facing, lift_world: *lift_world }
    };
    Ok(points.iter().enumerate().map(receiver).collect())
}
