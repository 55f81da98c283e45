//! Rays from points to suns, and to the nearest surface.

use std::sync::Arc;

use adumbra::grid::vec3::dot;
use adumbra_scene::UpAxis;
use adumbra_truth::trace::{Hit, Ray, TraceOptions, Tracer};
use numpy::{Element, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use rayon::ThreadPool;
use rayon::prelude::*;
use self_cell::self_cell;

use crate::arrays::{Places, Rooms, Triples, zeros};

/// Number of rays per batch.
const BATCH: usize = 1 << 10;
/// Number of batches between checks whether Python was interrupted.
const BLOCK: usize = 1 << 7;

self_cell!(
    /// A scene and its tracer.
    pub(crate) struct Traced {
        owner: Arc<adumbra_scene::Scene>,
        #[covariant]
        dependent: Tracer,
    }
);

impl Traced {
    /// Prepares a scene for rays. Cost: 2 microseconds per triangle.
    pub(crate) fn build(scene: &Arc<adumbra_scene::Scene>, options: TraceOptions) -> Self {
        Self::new(Arc::clone(scene), |scene| Tracer::build(scene, options))
    }
}

/// Returns `answer(origin, to_sun)` for each sun of each point, N × K. It is `T::default()` for suns without
/// length, and for those behind the surface of a point with a normal. The other suns are unit vectors.
/// Origins are `lift` from the points, along their normals, or else towards the sun. Between blocks of rays,
/// of which each answer takes `rays`, Python can be interrupted.
///
/// # Errors
/// Returns `ValueError` for normals that are not unit vectors, and `MemoryError`.
pub(crate) fn each_sun<'py, T: Element + Copy + Default + Send>(
    py: Python<'py>,
    pool: &ThreadPool,
    places: Places<'_>,
    suns: &[[f64; 3]],
    lift: f64,
    rays: usize,
    answer: impl Fn([f64; 3], [f64; 3]) -> T + Sync,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let places = places.with_unit_normals()?;
    let array: Bound<'py, PyArray2<T>> = zeros(py, (places.len(), suns.len()))?;
    let of_batch = BATCH.div_ceil(rays);
    let of_block = of_batch * BLOCK;
    let mut out = array.readwrite();
    for (block, out) in out.as_slice_mut()?.chunks_mut(of_block).enumerate() {
        let batches = out.par_chunks_mut(of_batch).enumerate();
        let trace = || {
            batches.for_each_init(Rooms::default, |rooms, (batch, out)| {
                let first = block * of_block + batch * of_batch;
                let first_row = first / suns.len();
                let end_row = (first + out.len()).div_ceil(suns.len());
                let (points, normals) = places.range(first_row..end_row, rooms);
                for (at, out) in (first..).zip(out) {
                    let (row, sun) = (at / suns.len() - first_row, suns[at % suns.len()]);
                    let normal = normals.map(|normals| normals[row]);
                    let is_behind = normal.is_some_and(|normal| dot(normal, sun) <= 0.0);
                    if !is_behind && sun != [0.0; 3] {
                        let away = normal.unwrap_or(sun);
                        *out = answer(std::array::from_fn(|a| points[row][a] + lift * away[a]), sun);
                    }
                }
            });
        };
        py.detach(|| pool.install(trace));
        py.check_signals()?;
    }
    Ok(array)
}

/// Returns the distance to the nearest surface in a direction, infinite where there is none, and its unit
/// normal on the side of the point, N × 3. The direction and the normals are of axes in which `up` points up.
#[allow(clippy::type_complexity, reason = "the two arrays of a hit")]
pub(crate) fn nearest<'py>(
    py: Python<'py>,
    pool: &ThreadPool,
    tracer: &Tracer<'_>,
    points: Triples<'_>,
    up: UpAxis,
    direction: [f64; 3],
) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>)> {
    let direction = up.to_scene(direction);
    let distances: Bound<'py, PyArray1<f64>> = zeros(py, points.len())?;
    let normals: Bound<'py, PyArray2<f64>> = zeros(py, (points.len(), 3))?;
    let (mut of_distances, mut of_normals) = (distances.readwrite(), normals.readwrite());
    let blocks = of_distances.as_slice_mut()?.chunks_mut(BATCH * BLOCK);
    let blocks = blocks.zip(of_normals.as_slice_mut()?.as_chunks_mut::<3>().0.chunks_mut(BATCH * BLOCK));
    for (block, (distances, normals)) in blocks.enumerate() {
        let batches = distances.par_chunks_mut(BATCH).zip(normals.par_chunks_mut(BATCH)).enumerate();
        let find = || {
            batches.for_each_init(Vec::new, |room, (batch, (distances, normals))| {
                let first = (block * BLOCK + batch) * BATCH;
                let points = points.range(first..first + distances.len(), room);
                for ((&origin, distance), normal) in points.iter().zip(distances).zip(normals) {
                    let ray = Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY };
                    let hit = tracer.nearest_surface(&ray);
                    *distance = hit.map_or(f64::INFINITY, |hit| hit.t);
                    let facing = |hit: Hit| if hit.front { hit.normal } else { hit.normal.map(|c| -c) };
                    *normal = up.to_file(hit.map_or([0.0; 3], facing));
                }
            });
        };
        py.detach(|| pool.install(find));
        py.check_signals()?;
    }
    Ok((distances, normals))
}
