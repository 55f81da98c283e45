//! Conversion between the layouts of a graph, and between graphs and quadtrees.

mod depths;
#[cfg(test)]
mod depths_tests;
#[cfg(test)]
mod packed_tests;
mod unpack;

use std::borrow::Cow;

pub use depths::{depths_of, graph_of_depths};
pub use unpack::unpack;

use crate::dag::PackError;
use crate::dag::build::pack::pack;
use crate::dag::packed::PackedError;
use crate::dag::plain::Dag;
use crate::dag::{DagBody, DagFileError, DagLayout};

/// Converts a graph to a layout.
///
/// # Errors
/// Returns [`PackError`] if it has no packed form.
pub fn body_in(layout: DagLayout, dag: Dag) -> Result<DagBody, PackError> {
    Ok(match layout {
        DagLayout::Plain => DagBody::Plain(dag),
        DagLayout::Packed => DagBody::Packed(pack(&dag)?),
    })
}

/// Returns a graph in the plain layout. Cost: none if it already is, otherwise that of [`unpack`].
///
/// # Errors
/// Returns [`DagFileError::Packed`] if the packed graph is not valid, and [`DagFileError::TooLarge`] if the
/// plain one could be too large: a few bytes can represent any number of root cubes.
pub fn graph_of(body: &DagBody) -> Result<Cow<'_, Dag>, DagFileError> {
    Ok(match body {
        DagBody::Plain(dag) => Cow::Borrowed(dag),
        DagBody::Packed(packed) => match unpack(packed) {
            Err(PackedError::TooLarge(limit)) => return Err(limit.into()),
            found => Cow::Owned(found?),
        },
    })
}
