//! Visibility by ray tracing.

use std::sync::Arc;

use adumbra_truth::trace::{Ray, TraceOptions, Tracer};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use rayon::prelude::*;
use self_cell::self_cell;

use crate::arrays::{Triples, TriplesArray, rows};
use crate::errors::Failure;
use crate::pool::pool;
use crate::scene::Scene;
use crate::watch::watched;

/// Number of rays per batch.
const BATCH: usize = 1 << 10;
/// Number of rays between checks whether Python was interrupted.
const BLOCK: usize = 1 << 17;

self_cell!(
    /// A scene and its tracer.
    struct Traced {
        owner: Arc<adumbra_scene::Scene>,
        #[covariant]
        dependent: Tracer,
    }
);

/// A scene that is ready for rays.
#[pyclass(frozen, module = "adumbra._native")]
pub(crate) struct Rays {
    traced: Traced,
}

#[pymethods]
impl Rays {
    /// Prepares a scene.
    #[new]
    fn new(py: Python<'_>, scene: &Scene) -> PyResult<Self> {
        let options = TraceOptions { ignore_alpha: scene.ignore_alpha };
        let traced = watched(py, None, |_| {
            let build = || Traced::new(Arc::clone(&scene.scene), |scene| Tracer::build(scene, options));
            Ok(pool(None)?.install(build))
        })?;
        Ok(Self { traced })
    }

    /// Returns the visibility of each sun, N × K, from points that are moved by `lift` along their normals.
    fn visibility<'py>(
        &self,
        py: Python<'py>,
        points: TriplesArray<'py>,
        suns: PyReadonlyArray2<'py, f64>,
        normals: Option<TriplesArray<'py>>,
        lift: f64,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (points, suns) = (points.rows()?, rows(&suns)?);
        let normals = normals.as_ref().map(TriplesArray::rows).transpose()?;
        if let Some(other) = normals.map(Triples::len).filter(|&n| n != points.len()) {
            let what = format!("normals: {other} rows for {} points; give one for each point", points.len());
            return Err(Failure::Value(what).into());
        }
        let pool = pool(None)?;
        let array = PyArray2::<f32>::zeros(py, [points.len(), suns.len()], false);
        if suns.is_empty() {
            return Ok(array);
        }
        let origins = Origins { points, normals, lift };
        let tracer = self.traced.borrow_dependent();
        let rows_of = |rays: usize| rays.div_ceil(suns.len());
        let mut out = array.readwrite();
        for (block, out) in out.as_slice_mut()?.chunks_mut(rows_of(BLOCK) * suns.len()).enumerate() {
            let first = block * rows_of(BLOCK);
            py.detach(|| {
                pool.install(|| {
                    let batches = out.par_chunks_mut(rows_of(BATCH) * suns.len()).enumerate();
                    batches.for_each(|(batch, out)| {
                        trace(tracer, &origins, first + batch * rows_of(BATCH), suns, out);
                    });
                });
            });
            py.check_signals()?;
        }
        Ok(array)
    }

    /// Returns the distance to the nearest surface in a direction, infinite where there is none, and its unit
    /// normal on the side of the point, N × 3.
    #[allow(clippy::type_complexity, reason = "the two arrays of a hit")]
    fn nearest<'py>(
        &self,
        py: Python<'py>,
        points: TriplesArray<'py>,
        direction: [f64; 3],
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>)> {
        let points = points.rows()?;
        let pool = pool(None)?;
        let distances = PyArray1::<f64>::zeros(py, points.len(), false);
        let normals = PyArray2::<f64>::zeros(py, [points.len(), 3], false);
        let tracer = self.traced.borrow_dependent();
        let (mut of_distances, mut of_normals) = (distances.readwrite(), normals.readwrite());
        let blocks = of_distances.as_slice_mut()?.chunks_mut(BLOCK);
        let blocks = blocks.zip(of_normals.as_slice_mut()?.as_chunks_mut::<3>().0.chunks_mut(BLOCK));
        for (block, (distances, normals)) in blocks.enumerate() {
            let rows = distances.par_chunks_mut(BATCH).zip(normals.par_chunks_mut(BATCH)).enumerate();
            let find =
                || {
                    rows.for_each(|(batch, (distances, normals))| {
                        let first = block * BLOCK + batch * BATCH;
                        let mut room = Vec::new();
                        let points = points.range(first..first + distances.len(), &mut room);
                        for ((&origin, distance), normal) in points.iter().zip(distances).zip(normals) {
                            let ray = Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY };
                            let hit = tracer.nearest_surface(&ray);
                            *distance = hit.map_or(f64::INFINITY, |hit| hit.t);
                            *normal = hit.map_or([0.0; 3], |hit| {
                                if hit.front { hit.normal } else { hit.normal.map(|c| -c) }
                            });
                        }
                    });
                };
            py.detach(|| pool.install(find));
            py.check_signals()?;
        }
        Ok((distances, normals))
    }
}

/// Where rays start.
struct Origins<'a> {
    points: Triples<'a>,
    normals: Option<Triples<'a>>,
    lift: f64,
}

/// Traces the rays of the points from index `first` on. All suns of a point follow each other.
fn trace(tracer: &Tracer<'_>, origins: &Origins<'_>, first: usize, suns: &[[f64; 3]], out: &mut [f32]) {
    let (mut of_points, mut of_normals) = (Vec::new(), Vec::new());
    let range = first..first + out.len() / suns.len();
    let normals = origins.normals.map(|normals| normals.range(range.clone(), &mut of_normals));
    let points = origins.points.range(range, &mut of_points);
    for (i, (&point, out)) in points.iter().zip(out.chunks_exact_mut(suns.len())).enumerate() {
        let normal = normals.map_or([0.0; 3], |normals| normals[i]);
        let origin = std::array::from_fn(|a| point[a] + origins.lift * normal[a]);
        for (&sun, out) in suns.iter().zip(out) {
            *out = f32::from(u8::from(tracer.sun_visible(origin, sun)));
        }
    }
}
