//! Paths of a sun.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

use adumbra::stream::BytesSource;
use adumbra::{Filter, IoError, PathSampler, PointVisibility, Sun, SunPath, SunStep};
use adumbra_bake::Watch;
use adumbra_files::replace_file;
use adumbra_path::{PathOptions, bake_path};
use adumbra_scene::UpAxis;
use adumbra_solar::Day;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arrays::{GivenPlaces, Places};
use crate::axes::name_of;
use crate::bake::Options;
use crate::errors::Failure;
use crate::file::{look_up, up_of};
use crate::pool::pool;
use crate::scene::Scene;
use crate::watch::watched;

/// A sun path in memory.
#[pyclass(frozen, module = "adumbra._native")]
pub(crate) struct Path {
    path: SunPath,
    source: Arc<BytesSource<Vec<u8>>>,
    /// The axis that points up in the scene's file.
    up: UpAxis,
}

impl Path {
    /// Reads a path. Must run on a pool of this package, because it decodes the first key.
    fn decode(bytes: Vec<u8>, name: &str) -> Result<Self, Failure> {
        let source = Arc::new(BytesSource(bytes));
        let path = SunPath::open(Arc::clone(&source) as _, name)?;
        let up = up_of(&path.key(0)?);
        Ok(Self { path, source, up })
    }
}

#[pymethods]
impl Path {
    /// Decodes the bytes of a file.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: Vec<u8>) -> PyResult<Self> {
        watched(py, None, |_| pool(None)?.install(|| Self::decode(data, "the data")))
    }

    /// Returns the bytes of the file.
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.source.0)
    }

    /// The axis that points up: "y" or "z".
    #[getter(up)]
    fn up_name(&self) -> &'static str {
        name_of(self.up)
    }

    /// Reads a file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        watched(py, None, |_| {
            let bytes = fs::read(&path).map_err(IoError::at("read", &path))?;
            pool(None)?.install(|| Self::decode(bytes, &path.to_string_lossy()))
        })
    }

    /// Bakes a path. `day` is text as the program's `--sun-path` takes it.
    #[staticmethod]
    fn bake(
        py: Python<'_>,
        scene: &Scene,
        day: &str,
        options: Options,
        limits: (f64, f64),
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let (error_percent, lowest_degrees) = limits;
        let day: Day = day.parse().map_err(Failure::from)?;
        let bake = options.for_bake(scene)?;
        let options = PathOptions { error_percent, lowest_degrees, ..PathOptions::new(bake) };
        watched(py, None, |watch| {
            let suns = day.steps()?;
            let offset = suns.first().map_or(0, |sun| day.zone().offset_seconds(sun.unix_seconds));
            let location = [day.location.latitude_degrees(), day.location.longitude_degrees()];
            let steps: Vec<SunStep> = suns
                .iter()
                .map(|sun| SunStep { seconds: sun.unix_seconds, towards_sun: sun.position.towards() })
                .collect();
            // Each key is a separate bake, so its root blocks do not measure the progress of the whole path.
            let watch = Watch::new(&|_| {}, watch.cancel);
            pool(threads)?.install(|| {
                let keys = bake_path(&scene.scene, &steps, &options, watch, |_| {})?.keys;
                let keys: Vec<_> = keys.into_iter().map(|key| (key.seconds, key.bytes)).collect();
                let mut bytes = Vec::new();
                SunPath::write(&mut bytes, steps, &keys, offset, Some(location))
                    .map_err(adumbra_path::Error::Write)?;
                Self::decode(bytes, "the path")
            })
        })
    }

    /// Writes the file. An earlier file is replaced as a whole.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<u64> {
        let bytes = &self.source.0;
        let write = || replace_file(&path, |out| out.write_all(bytes).map(|()| bytes.len() as u64));
        watched(py, None, |_| Ok(write()?))
    }

    /// The first and the last moment, seconds after 1970.
    #[getter]
    fn span(&self) -> (f64, f64) {
        let steps = self.path.steps();
        (steps[0].seconds, steps[steps.len() - 1].seconds)
    }

    /// The moments of the keys, seconds after 1970.
    #[getter]
    fn keys(&self) -> Vec<f64> {
        self.path.key_seconds()
    }

    /// Returns the unit vector towards the sun at a moment, or `None` at night and outside the path.
    fn sun_at(&self, seconds: f64) -> Option<[f64; 3]> {
        self.path.sun_at(seconds).map(|sun| self.up.to_file(sun))
    }

    /// Returns the visibility of points at a moment of the path.
    fn visibility<'py>(
        &self,
        py: Python<'py>,
        places: GivenPlaces<'py>,
        seconds: f64,
        filter: u32,
        quick: bool,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, numpy::PyArray1<f32>>> {
        let filter = Filter::try_from(filter).map_err(Failure::from)?;
        let pool = pool(threads)?;
        let sampler = watched(py, None, |_| {
            let (Some(sun), Some([first, second])) = (self.path.sun_at(seconds), self.path.keys_at(seconds))
            else {
                return Ok(None);
            };
            let sun = Sun::from_direction(sun)?.towards();
            let keys = || {
                let first_file = self.path.key(first)?;
                let second_file = if second == first { first_file.clone() } else { self.path.key(second)? };
                Ok::<_, Failure>([first_file, second_file])
            };
            let [first_file, second_file] = pool.install(keys)?;
            let sampler = PathSampler::new([&first_file, &second_file], sun, filter);
            let too_far = || Failure::Value("time: the sun is too far from the nearest key".to_owned());
            let sampler = sampler.ok_or_else(too_far)?;
            Ok(Some(if quick { sampler.quick() } else { sampler }))
        })?;
        let places = Places::new(&places, self.up)?;
        look_up(py, &pool, places, |points, normals, out| {
            if let Some(sampler) = &sampler {
                out.copy_from_slice(&PointVisibility::visibilities(sampler, points, normals));
            }
            Ok(())
        })
    }
}
