//! The native part of the Python package `adumbra`. The package's Python modules check and document what
//! users pass. The code here must never panic, but expects arrays of the right shape.
//!
//! Data flows one way: errors, pool → watch, arrays → scene, file → bake, rays, sunlight, verify → farm,
//! path.

mod arrays;
mod bake;
mod errors;
mod farm;
mod file;
mod path;
mod pool;
mod rays;
mod scene;
mod sunlight;
mod verify;
mod watch;

use adumbra::Sun;
use numpy::{PyArray1, ToPyArray};
use pyo3::prelude::*;

use crate::errors::Failure;

/// The functions and classes that the package wraps.
#[pymodule]
mod _native {
    #[pymodule_export]
    use super::bake::{bake, check_path};
    #[pymodule_export]
    use super::farm::{Baker, Plan};
    #[pymodule_export]
    use super::file::File;
    #[pymodule_export]
    use super::path::Path;
    #[pymodule_export]
    use super::rays::Rays;
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::sun_from_angles;
    #[pymodule_export]
    use super::sunlight::{sky, sun_hours, sun_positions};
    #[pymodule_export]
    use super::verify::verify;
}

/// Returns the unit vector towards a sun at these compass angles, in degrees.
#[pyfunction]
fn sun_from_angles(py: Python<'_>, azimuth: f64, elevation: f64) -> PyResult<Bound<'_, PyArray1<f64>>> {
    Ok(Sun::from_angles(azimuth, elevation).map_err(Failure::from)?.towards().to_pyarray(py))
}
