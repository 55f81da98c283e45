//! Points, normals and directions in NumPy arrays, in the axes of the scene's own file.

use std::fmt::Debug;
use std::ops::Range;

use adumbra::grid::vec3::dot;
use adumbra_scene::UpAxis;
use numpy::ndarray::Dimension;
use numpy::{Element, PyArray, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::errors::Failure;

/// An array of N × 3 numbers, contiguous in C's order.
#[derive(FromPyObject)]
pub(crate) enum TriplesArray<'py> {
    F32(PyReadonlyArray2<'py, f32>),
    F64(PyReadonlyArray2<'py, f64>),
}

/// The rows of a [`TriplesArray`].
#[derive(Clone, Copy)]
enum Rows<'a> {
    F32(&'a [[f32; 3]]),
    F64(&'a [[f64; 3]]),
}

/// Rows of three numbers, of axes in which `up` points up.
#[derive(Clone, Copy)]
pub(crate) struct Triples<'a> {
    rows: Rows<'a>,
    up: UpAxis,
}

impl TriplesArray<'_> {
    /// Returns the rows.
    ///
    /// # Errors
    /// See [`rows`].
    pub(crate) fn rows(&self, up: UpAxis) -> PyResult<Triples<'_>> {
        let rows = match self {
            Self::F32(array) => Rows::F32(rows(array)?),
            Self::F64(array) => Rows::F64(rows(array)?),
        };
        Ok(Triples { rows, up })
    }
}

/// Returns the rows of an array of N × 3 numbers.
///
/// # Errors
/// Returns `ValueError` for an array of another shape or order.
pub(crate) fn rows<'a, T: Element>(array: &'a PyReadonlyArray2<'_, T>) -> PyResult<&'a [[T; 3]]> {
    match in_order(array)?.as_chunks::<3>() {
        (rows, []) if rows.is_empty() || array.shape()[1] == 3 => Ok(rows),
        _ => Err(PyValueError::new_err("an array of N rows of 3 numbers is needed")),
    }
}

/// Returns the numbers of an array, row by row.
///
/// # Errors
/// Returns `ValueError` for an array that is not contiguous in C's order.
pub(crate) fn in_order<'a, T: Element>(array: &'a PyReadonlyArray2<'_, T>) -> PyResult<&'a [T]> {
    if !array.is_c_contiguous() {
        return Err(PyValueError::new_err("an array that is contiguous in C's order is needed"));
    }
    Ok(array.as_slice()?)
}

/// Returns a new array of zeros.
///
/// # Errors
/// Returns NumPy's `MemoryError`.
pub(crate) fn zeros<'py, T: Element, D: Dimension>(
    py: Python<'py>,
    shape: impl IntoPyObject<'py>,
) -> PyResult<Bound<'py, PyArray<T, D>>> {
    let array = py.import("numpy")?.call_method1("zeros", (shape, numpy::dtype::<T>(py)))?;
    Ok(array.cast_into()?)
}

impl<'a> Triples<'a> {
    /// Returns the number of rows.
    pub(crate) fn len(self) -> usize {
        match self.rows {
            Rows::F32(rows) => rows.len(),
            Rows::F64(rows) => rows.len(),
        }
    }

    /// Returns rows in double precision and in the world's axes, in which Y points up. Other rows are
    /// converted into `room`.
    pub(crate) fn range<'r>(self, range: Range<usize>, room: &'r mut Vec<[f64; 3]>) -> &'r [[f64; 3]]
    where
        'a: 'r,
    {
        room.clear();
        match (self.rows, self.up) {
            (Rows::F64(rows), UpAxis::Y) => return &rows[range],
            (Rows::F64(rows), up) => room.extend(rows[range].iter().map(|&row| up.to_scene(row))),
            (Rows::F32(rows), up) => {
                room.extend(rows[range].iter().map(|row| up.to_scene(row.map(f64::from))));
            }
        }
        room
    }
}

/// Points and normals, as Python gives them.
pub(crate) type GivenPlaces<'py> = (TriplesArray<'py>, Option<TriplesArray<'py>>);

/// Points and normals, and how far from the points rays start, along the normals or else towards the sun.
pub(crate) type GivenOrigins<'py> = (GivenPlaces<'py>, f64);

/// Returns the number and the text of the first row of which something holds.
fn first<T: Copy + Debug>(rows: &[[T; 3]], holds: impl Fn([T; 3]) -> bool) -> Option<(usize, String)> {
    let row = rows.iter().position(|&row| holds(row))?;
    Some((row, format!("{:?}", rows[row])))
}

/// Points, and the normals of the surfaces that they are on.
#[derive(Clone, Copy)]
pub(crate) struct Places<'a> {
    points: Triples<'a>,
    normals: Option<Triples<'a>>,
}

/// Room for converted points and normals.
pub(crate) type Rooms = [Vec<[f64; 3]>; 2];

impl<'a> Places<'a> {
    /// Returns points and normals of axes in which `up` points up.
    ///
    /// # Errors
    /// Returns `ValueError` unless there is one normal for each point.
    pub(crate) fn new((points, normals): &'a GivenPlaces<'_>, up: UpAxis) -> PyResult<Self> {
        let points = points.rows(up)?;
        let normals = normals.as_ref().map(|normals| normals.rows(up)).transpose()?;
        if let Some(other) = normals.map(Triples::len).filter(|&n| n != points.len()) {
            let what = format!("normals: {other} rows for {} points; give one for each point", points.len());
            return Err(Failure::Value(what).into());
        }
        Ok(Self { points, normals })
    }

    /// Refuses normals that are not unit vectors, to a hundredth.
    ///
    /// # Errors
    /// Returns `ValueError`, which names the first one.
    pub(crate) fn with_unit_normals(self) -> PyResult<Self> {
        let length = |normal: [f64; 3]| dot(normal, normal).sqrt();
        let is_wrong = |length: f64| !(0.99..=1.01).contains(&length);
        let wrong = self.normals.and_then(|normals| match normals.rows {
            Rows::F32(rows) => first(rows, |row| is_wrong(length(row.map(f64::from)))),
            Rows::F64(rows) => first(rows, |row| is_wrong(length(row))),
        });
        match wrong {
            None => Ok(self),
            Some((row, normal)) => Err(Failure::Value(format!(
                "normals[{row}] is {normal}, which is not a unit vector; divide normals by \
                 np.linalg.norm(normals, axis=1, keepdims=True), and leave out points without one"
            ))
            .into()),
        }
    }

    /// Returns the number of points.
    pub(crate) fn len(self) -> usize {
        self.points.len()
    }

    /// Returns points and normals as [`Triples::range`] does.
    pub(crate) fn range<'r>(
        self,
        range: Range<usize>,
        [of_points, of_normals]: &'r mut Rooms,
    ) -> (&'r [[f64; 3]], Option<&'r [[f64; 3]]>)
    where
        'a: 'r,
    {
        let normals = self.normals.map(|normals| normals.range(range.clone(), of_normals));
        (self.points.range(range, of_points), normals)
    }
}
