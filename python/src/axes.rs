//! The axes of a scene's file, in which Python gives and gets coordinates, and those of the world, in which Y
//! points up.

use adumbra::Bounds;
use adumbra::grid::vec3::normalize;
use adumbra_scene::UpAxis;
use pyo3::prelude::*;

/// Converts "y", "z" or None. The caller has checked the value.
pub(crate) fn up_axis(axis: &Bound<'_, PyAny>) -> PyResult<Option<UpAxis>> {
    let name: Option<String> = axis.extract()?;
    Ok(name.map(|name| self::axis(&name)))
}

/// Converts "y" or "z". The caller has checked the value.
pub(crate) fn axis(name: &str) -> UpAxis {
    if name == "z" { UpAxis::Z } else { UpAxis::Y }
}

/// Returns the smallest and the largest coordinates of a box along a file's axes.
pub(crate) fn bounds_in_file(up: UpAxis, bounds: &Bounds) -> ([f64; 3], [f64; 3]) {
    let [a, b] = [bounds.min, bounds.max].map(|corner| up.to_file(corner));
    (std::array::from_fn(|i| a[i].min(b[i])), std::array::from_fn(|i| a[i].max(b[i])))
}

/// Returns "y" or "z".
pub(crate) fn name_of(up: UpAxis) -> &'static str {
    match up {
        UpAxis::Y => "y",
        UpAxis::Z => "z",
    }
}

/// Returns a box along the world's axes from two corners of one along a file's.
pub(crate) fn world_bounds(up: UpAxis, (min, max): ([f64; 3], [f64; 3])) -> Bounds {
    let [a, b] = [min, max].map(|corner| up.to_scene(corner));
    // Z up: the world's Z falls where the file's Y rises.
    match up {
        UpAxis::Y => Bounds { min: a, max: b },
        UpAxis::Z => Bounds { min: [a[0], a[1], b[2]], max: [b[0], b[1], a[2]] },
    }
}

/// Returns a vector of length 1. One without length stays as it is.
pub(crate) fn unit(vector: [f64; 3]) -> [f64; 3] {
    let largest = vector.iter().fold(0.0, |largest: f64, c| largest.max(c.abs()));
    if largest == 0.0 {
        return vector;
    }
    // Divided by the largest, no square overflows.
    normalize(vector.map(|c| c / largest))
}
