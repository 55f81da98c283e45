//! Hours of sun, and the visible sky.

use adumbra_scene::UpAxis;
use adumbra_solar::Day;
use adumbra_sunlight::points::Facing;
use adumbra_sunlight::{Patches, Receiver, Suns, sky_views};
use numpy::{PyArray1, PyArray2, PyArrayMethods, ToPyArray};
use pyo3::prelude::*;

use crate::arrays::{GivenOrigins, Places, Rooms};
use crate::errors::Failure;
use crate::pool::pool;
use crate::scene::Scene;
use crate::watch::watched;

/// Seconds of an hour.
const HOUR_SECONDS: f64 = 3600.0;

type Numbers<'py> = Bound<'py, PyArray1<f64>>;

/// Returns the hours of each point; the point, start and end of each span in which one is lit, in seconds
/// after 1970; and the name of the clock's zone. `day` is text as the program's `--sun-path` takes it.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "the arrays of hours and spans")]
pub(crate) fn sun_hours<'py>(
    py: Python<'py>,
    scene: &Scene,
    origins: GivenOrigins<'py>,
    day: &str,
    threads: Option<usize>,
    report: Option<Py<PyAny>>,
) -> PyResult<(Numbers<'py>, Bound<'py, PyArray1<i64>>, Numbers<'py>, Numbers<'py>, String)> {
    let receivers = receivers(&origins, scene.up())?;
    let day: Day = day.parse().map_err(Failure::from)?;
    let found = watched(py, report, |watch| {
        let suns = Suns::new(&day.arcs()?);
        let pool = pool(threads)?;
        let tracer = scene.tracer(&pool)?;
        Ok(pool.install(|| suns.hours(tracer, &receivers, watch))?)
    })?;
    let hours: Vec<f64> = (0..found.len()).map(|point| found.seconds(point) / HOUR_SECONDS).collect();
    let (mut points, mut starts, mut ends) = (Vec::new(), Vec::new(), Vec::new());
    for point in 0..found.len() {
        for &[start, end] in found.spans(point) {
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
