//! Scenes: loaded from a file, or made of arrays.

use std::path::PathBuf;
use std::sync::Arc;

use adumbra::Sun;
use adumbra_scene::{LoadNotes, LoadOptions, MoverPolicy, NameFilter, UpAxis, from_triangles, load};
use numpy::{PyArray2, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;

use crate::arrays::rows;
use crate::errors::Failure;
use crate::pool::pool;
use crate::watch::watched;

/// Direction towards the sun, as in the program, if neither the caller nor the scene gives one.
const DEFAULT_SUN: [f64; 3] = [0.5, 0.8, 0.35];

/// A scene, which bakes and rays share.
#[pyclass(frozen, module = "adumbra._native")]
pub(crate) struct Scene {
    pub(crate) scene: Arc<adumbra_scene::Scene>,
    /// Whether masked materials count as opaque.
    pub(crate) ignore_alpha: bool,
    /// The file that it was loaded from.
    pub(crate) path: Option<PathBuf>,
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
    max_memory: Option<u64>,
}

#[pymethods]
impl Scene {
    /// Loads a file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf, options: Loading) -> PyResult<Self> {
        let scene = watched(py, None, |_| {
            let options = LoadOptions {
                filter: NameFilter::new(&options.only, &options.exclude)?,
                ignore_alpha: options.ignore_alpha,
                movers: if options.include_animated { MoverPolicy::Freeze } else { MoverPolicy::Skip },
                up: options.up,
                allow_outside: options.allow_outside,
                max_memory_bytes: options.max_memory,
                strict: options.strict,
                ..LoadOptions::default()
            };
            Ok(pool(None)?.install(|| load(&path, &options))?)
        })?;
        Ok(Self { scene: Arc::new(scene), ignore_alpha: options.ignore_alpha, path: Some(path) })
    }

    /// Makes a scene from N × 3 vertices and M × 3 faces.
    #[staticmethod]
    fn from_mesh(
        py: Python<'_>,
        vertices: PyReadonlyArray2<'_, f64>,
        faces: PyReadonlyArray2<'_, u32>,
    ) -> PyResult<Self> {
        let (vertices, faces) = (rows(&vertices)?, rows(&faces)?);
        // Arrays are not a broken file, so report a wrong value.
        let wrong = |error: adumbra_scene::Error| Failure::Value(error.to_string());
        let scene = watched(py, None, |_| from_triangles("mesh", vertices, faces).map_err(wrong))?;
        Ok(Self { scene: Arc::new(scene), ignore_alpha: false, path: None })
    }

    /// The smallest and the largest coordinates.
    #[getter]
    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let bounds = self.scene.bounds();
        (bounds.min, bounds.max)
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
    fn sun(&self) -> PyResult<[f64; 3]> {
        let of_light = self.scene.suns.iter().find_map(|light| Sun::from_direction(light.towards).ok());
        let sun = of_light.map_or_else(|| Sun::from_direction(DEFAULT_SUN), Ok);
        Ok(sun.map_err(Failure::from)?.towards())
    }

    /// Sentences about what the loader left out or changed.
    #[getter]
    fn notes(&self) -> Vec<String> {
        notes(&self.scene.notes)
    }

    /// The triangles of all instances in world space: vertices and faces.
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
                vertices.extend(mesh.positions.iter().flat_map(|&p| instance.to_world(p)));
                faces.extend(mesh.triangles.iter().flatten().map(|corner| first + corner));
            }
            Ok((vertices, faces))
        })?;
        Ok((by_rows(py, &vertices)?, by_rows(py, &faces)?))
    }
}

/// Returns an array of rows of three numbers.
fn by_rows<'py, T: numpy::Element>(py: Python<'py>, numbers: &[T]) -> PyResult<Bound<'py, PyArray2<T>>> {
    use numpy::PyArrayMethods;
    numbers.to_pyarray(py).reshape([numbers.len() / 3, 3])
}

/// Converts "y", "z" or None. The caller has checked the value.
pub(crate) fn up_axis(axis: &Bound<'_, PyAny>) -> PyResult<Option<UpAxis>> {
    let axis: Option<String> = axis.extract()?;
    Ok(axis.map(|axis| if axis == "z" { UpAxis::Z } else { UpAxis::Y }))
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
