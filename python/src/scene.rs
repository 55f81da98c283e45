//! Scenes: loaded from a file, or made of arrays.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use adumbra::Sun;
use adumbra_scene::{
    HeightSurface, Heights, LoadNotes, LoadOptions, MoverPolicy, NameFilter, UpAxis, from_heights,
    from_triangles, load,
};
use adumbra_truth::trace::{TraceOptions, Tracer};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use rayon::ThreadPool;

use crate::arrays::{GivenOrigins, Places, TriplesArray, in_order, rows};
use crate::axes::{axis, bounds_in_file, name_of, unit, up_axis};
use crate::errors::Failure;
use crate::pool::pool;
use crate::rays::{Traced, each_sun, nearest};
use crate::watch::watched;

/// Direction towards the sun, as in the program, if neither the caller nor the scene gives one.
const DEFAULT_SUN: [f64; 3] = [0.5, 0.8, 0.35];

/// Rays to the sun's disc, per point and sun.
const DISC_RAYS: u32 = 256;
/// Seed of these rays.
const DISC_SEED: u64 = 1;

/// A scene, which bakes and rays share. Numbers from Python and for Python are of the axes of its file.
#[pyclass(frozen, module = "adumbra._native")]
pub(crate) struct Scene {
    pub(crate) scene: Arc<adumbra_scene::Scene>,
    /// Whether masked materials count as opaque.
    pub(crate) ignore_alpha: bool,
    /// The file that it was loaded from.
    pub(crate) path: Option<PathBuf>,
    /// The smallest and the largest coordinates, in the scene's own axes.
    bounds: ([f64; 3], [f64; 3]),
    /// Made when rays are traced for the first time.
    traced: OnceLock<Traced>,
}

impl Scene {
    fn new(scene: adumbra_scene::Scene, ignore_alpha: bool, path: Option<PathBuf>) -> Self {
        let bounds = bounds_in_file(scene.up, &scene.bounds());
        Self { scene: Arc::new(scene), ignore_alpha, path, bounds, traced: OnceLock::new() }
    }

    /// The axis that points up in the scene's file.
    pub(crate) fn up(&self) -> UpAxis {
        self.scene.up
    }

    /// Returns the tracer, which is built on the first call, by the threads of `pool`. Do not call this on a
    /// thread of a pool: one that waits here for the tracer could be the one that has to build it.
    pub(crate) fn tracer(&self, pool: &ThreadPool) -> Result<&Tracer<'_>, Failure> {
        let options = TraceOptions { ignore_alpha: self.ignore_alpha };
        let traced = self.traced.get_or_init(|| pool.install(|| Traced::build(&self.scene, options)));
        Ok(traced.borrow_dependent())
    }
}

/// The options of the loader, as Python gives them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Loading {
    only: Vec<String>,
    exclude: Vec<String>,
    ignore_alpha: bool,
    include_animated: bool,
    #[pyo3(from_py_with = up_axis)]
    up: Option<UpAxis>,
    allow_outside: bool,
    strict: bool,
}

#[pymethods]
impl Scene {
    /// Loads a file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf, options: Loading) -> PyResult<Self> {
        watched(py, None, |_| {
            let ignore_alpha = options.ignore_alpha;
            let options = LoadOptions {
                filter: NameFilter::new(&options.only, &options.exclude)?,
                ignore_alpha: options.ignore_alpha,
                movers: if options.include_animated { MoverPolicy::Freeze } else { MoverPolicy::Skip },
                up: options.up,
                allow_outside: options.allow_outside,
                strict: options.strict,
                ..LoadOptions::default()
            };
            let scene = pool(None)?.install(|| load(&path, &options))?;
            Ok(Self::new(scene, ignore_alpha, Some(path.clone())))
        })
    }

    /// Makes a scene from N × 3 vertices and M × 3 faces. There is one transmissivity for each face, or none.
    #[staticmethod]
    fn from_arrays(
        py: Python<'_>,
        vertices: PyReadonlyArray2<'_, f64>,
        faces: PyReadonlyArray2<'_, u32>,
        transmissivities: PyReadonlyArray1<'_, f32>,
        up: &str,
    ) -> PyResult<Self> {
        let (vertices, faces) = (rows(&vertices)?, rows(&faces)?);
        let shares = transmissivities.as_slice()?;
        // Arrays are not a broken file, so report a wrong value.
        let wrong = |error: adumbra_scene::Error| Failure::Value(error.to_string());
        let make = || from_triangles("arrays", vertices, faces, shares, axis(up)).map_err(wrong);
        watched(py, None, |_| Ok(Self::new(make()?, false, None)))
    }

    /// Makes a scene from rows of heights.
    #[staticmethod]
    #[pyo3(name = "from_heights")]
    fn of_heights(
        py: Python<'_>,
        heights: PyReadonlyArray2<'_, f64>,
        cell: f64,
        corner: [f64; 2],
        walls: bool,
        up: &str,
    ) -> PyResult<Self> {
        let [rows, columns] = *heights.shape() else {
            return Err(Failure::Value("heights: an array of two axes is needed".to_owned()).into());
        };
        let surface = if walls { HeightSurface::Blocks } else { HeightSurface::Centres };
        let raster = Heights { heights: in_order(&heights)?, size: [columns, rows], cell, corner, surface };
        let wrong = |error: adumbra_scene::Error| Failure::Value(error.to_string());
        let make = || from_heights("heights", &raster, axis(up)).map_err(wrong);
        watched(py, None, |_| Ok(Self::new(make()?, false, None)))
    }

    /// The axis that points up: "y" or "z".
    #[getter(up)]
    fn up_name(&self) -> &'static str {
        name_of(self.up())
    }

    /// The smallest and the largest coordinates.
    #[getter]
    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        self.bounds
    }

    /// The number of triangles, counting every instance.
    #[getter]
    fn triangles(&self) -> u64 {
        self.scene.instanced_triangles()
    }

    /// The number of triangles that cast shadows, counting every instance.
    #[getter]
    fn casting_triangles(&self) -> u64 {
        self.scene.casters().triangles
    }

    /// The unit vector towards the sun that a bake uses by default.
    #[getter]
    fn to_sun(&self) -> PyResult<[f64; 3]> {
        let of_light = self.scene.suns.iter().find_map(|light| Sun::from_direction(light.towards).ok());
        let sun = of_light.map_or_else(|| Sun::from_direction(DEFAULT_SUN), Ok);
        Ok(self.up().to_file(sun.map_err(Failure::from)?.towards()))
    }

    /// Sentences about what the loader left out or changed.
    #[getter]
    fn notes(&self) -> Vec<String> {
        notes(&self.scene.notes)
    }

    /// Returns whether each point sees the centre of each sun, N × K. A sun without length is one at night.
    fn sunlit<'py>(
        &self,
        py: Python<'py>,
        origins: GivenOrigins<'py>,
        suns: PyReadonlyArray2<'py, f64>,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyArray2<bool>>> {
        let (places, lift) = (Places::new(&origins.0, self.up())?, origins.1);
        let pool = pool(threads)?;
        let tracer = watched(py, None, |_| self.tracer(&pool))?;
        each_sun(py, &pool, places, &self.suns(&suns)?, lift, 1, |origin, sun| {
            tracer.sun_visible(origin, sun)
        })
    }

    /// Returns the share of the light of each sun's disc that arrives at each point, N × K. A sun without
    /// length is one at night.
    fn visibility<'py>(
        &self,
        py: Python<'py>,
        origins: GivenOrigins<'py>,
        suns: PyReadonlyArray2<'py, f64>,
        sun_degrees: f64,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (places, lift) = (Places::new(&origins.0, self.up())?, origins.1);
        let pool = pool(threads)?;
        let tracer = watched(py, None, |_| self.tracer(&pool))?;
        each_sun(py, &pool, places, &self.suns(&suns)?, lift, DISC_RAYS as usize, |origin, sun| {
            tracer.sun_disc_light(origin, sun, sun_degrees, DISC_RAYS, DISC_SEED)
        })
    }

    /// Returns the distance to the nearest surface in a direction, infinite where there is none, and its unit
    /// normal on the side of the point, N × 3.
    #[allow(clippy::type_complexity, reason = "the two arrays of a hit")]
    fn nearest<'py>(
        &self,
        py: Python<'py>,
        points: TriplesArray<'py>,
        direction: [f64; 3],
        threads: Option<usize>,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>)> {
        let pool = pool(threads)?;
        let tracer = watched(py, None, |_| self.tracer(&pool))?;
        nearest(py, &pool, tracer, points.rows(self.up())?, self.up(), direction)
    }

    /// The triangles of all instances: vertices and faces.
    #[allow(clippy::type_complexity, reason = "the two arrays of a mesh")]
    fn mesh<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u32>>)> {
        let (vertices, faces) = watched(py, None, |_| {
            let (mut vertices, mut faces) = (Vec::new(), Vec::new());
            for instance in &self.scene.instances {
                let mesh = &self.scene.meshes[instance.mesh as usize];
                let first = u32::try_from(vertices.len() / 3)
                    .ok()
                    .filter(|first| first.checked_add(mesh.positions.len() as u32).is_some())
                    .ok_or_else(|| {
                        Failure::Value("the scene's instances have more than 2^32 vertices".to_owned())
                    })?;
                let placed = mesh.positions.iter().map(|&p| self.up().to_file(instance.to_world(p)));
                vertices.extend(placed.flatten());
                faces.extend(mesh.triangles.iter().flatten().map(|corner| first + corner));
            }
            Ok((vertices, faces))
        })?;
        Ok((by_rows(py, vertices)?, by_rows(py, faces)?))
    }

    /// The transmissivities of all triangles, in the order of `mesh`.
    fn transmissivities<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        let (meshes, materials) = (&self.scene.meshes, &self.scene.materials);
        let of_instances = self.scene.instances.iter();
        let numbers = of_instances.flat_map(|instance| &meshes[instance.mesh as usize].triangle_materials);
        PyArray1::from_iter(py, numbers.map(|&number| materials[number as usize].transmissivity))
    }
}

impl Scene {
    /// Returns directions of the scene's axes as unit vectors of the world's. One without length stays as it
    /// is.
    fn suns(&self, suns: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<[f64; 3]>> {
        Ok(rows(suns)?.iter().map(|&sun| self.up().to_scene(unit(sun))).collect())
    }
}

/// Returns an array of rows of three numbers.
fn by_rows<'py, T: numpy::Element>(py: Python<'py>, numbers: Vec<T>) -> PyResult<Bound<'py, PyArray2<T>>> {
    let rows = numbers.len() / 3;
    numbers.into_pyarray(py).reshape([rows, 3])
}

fn notes(of: &LoadNotes) -> Vec<String> {
    let counted = [
        (of.degenerate_triangles, "degenerate triangles skipped"),
        (
            of.untriangulated_polygons,
            "polygons could not be triangulated properly; triangulate them in the program that made them",
        ),
        (of.blended_materials, "blended materials cast shadows where alpha >= 0.5"),
        (
            of.skipped_movers,
            "animated instances skipped, because they move; include_animated=True loads them in their first pose",
        ),
        (
            of.outside_textures,
            "textures outside the scene's folder not read; allow_outside=True reads them, for scenes that you trust",
        ),
    ];
    let counted =
        counted.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}"));
    let omissions = of.omissions.iter().map(|omission| format!("{omission} left out"));
    let up = of.looks_z_up.then(|| {
        "flat along Z, or much taller than wide, as a scene is in which Z points up; if so, give up=\"z\", and up=\"y\" if not"
            .to_owned()
    });
    let unmatched = of.unmatched_patterns.iter();
    let unmatched =
        unmatched.map(|pattern| format!("{}: {pattern}", if pattern.excludes { "exclude" } else { "only" }));
    of.warnings.iter().cloned().chain(unmatched).chain(up).chain(omissions).chain(counted).collect()
}
