//! The native part of the Python package `adumbra`. The package's Python modules check and document what
//! users pass. The code here must never panic, but expects arrays of the right shape.
//!
//! Data flows one way: errors, pool, axes → watch, arrays → sun, rays → scene → file → bake, sunlight,
//! verify → farm, path. `program` uses none of these.

mod arrays;
mod axes;
mod bake;
mod errors;
mod farm;
mod file;
mod path;
mod pool;
mod program;
mod rays;
mod scene;
mod sun;
mod sunlight;
mod verify;
mod watch;

use pyo3::prelude::*;

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
    use super::program::run_program;
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::sun::{sun_angles, sun_directions};
    #[pymodule_export]
    use super::sunlight::{sky, sun_hours};
    #[pymodule_export]
    use super::verify::verify;
}
