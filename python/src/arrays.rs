//! Points, normals and directions in NumPy arrays.

use std::ops::Range;

use numpy::{AsSliceError, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// An array of N × 3 numbers, contiguous in C's order.
#[derive(FromPyObject)]
pub(crate) enum TriplesArray<'py> {
    F32(PyReadonlyArray2<'py, f32>),
    F64(PyReadonlyArray2<'py, f64>),
}

/// The rows of a [`TriplesArray`].
#[derive(Clone, Copy)]
pub(crate) enum Triples<'a> {
    F32(&'a [[f32; 3]]),
    F64(&'a [[f64; 3]]),
}

impl TriplesArray<'_> {
    /// Returns the rows.
    ///
    /// # Errors
    /// Returns `ValueError` for an array of another shape or order.
    pub(crate) fn rows(&self) -> PyResult<Triples<'_>> {
        Ok(match self {
            Self::F32(array) => Triples::F32(rows(array)?),
            Self::F64(array) => Triples::F64(rows(array)?),
        })
    }
}

/// Returns the rows of an array of N × 3 numbers.
pub(crate) fn rows<'a, T: numpy::Element>(array: &'a PyReadonlyArray2<'_, T>) -> PyResult<&'a [[T; 3]]> {
    let wrong = |_: AsSliceError| PyValueError::new_err("an array that is contiguous in C's order is needed");
    match array.as_slice().map_err(wrong)?.as_chunks::<3>() {
        (rows, []) if rows.is_empty() || numpy::PyUntypedArrayMethods::shape(&**array)[1] == 3 => Ok(rows),
        _ => Err(PyValueError::new_err("an array of N rows of 3 numbers is needed")),
    }
}

impl<'a> Triples<'a> {
    /// Returns the number of rows.
    pub(crate) fn len(self) -> usize {
        match self {
            Self::F32(rows) => rows.len(),
            Self::F64(rows) => rows.len(),
        }
    }

    /// Returns rows in double precision. Rows in single precision are converted into `room`.
    pub(crate) fn range<'r>(self, range: Range<usize>, room: &'r mut Vec<[f64; 3]>) -> &'r [[f64; 3]]
    where
        'a: 'r,
    {
        match self {
            Self::F64(rows) => &rows[range],
            Self::F32(rows) => {
                room.clear();
                room.extend(rows[range].iter().map(|row| row.map(f64::from)));
                room
            }
        }
    }
}
