//! Conversion between layouts.

mod depths;
#[cfg(test)]
mod depths_tests;
#[cfg(test)]
mod packed_tests;
mod unpack;

use std::borrow::Cow;

use adumbra::layout::packed::PackedError;
use adumbra::layout::plain::Dag;
use adumbra::{FormatError, Layout, LightBody};
pub use depths::{depths_of, graph_of_depths};
pub use unpack::unpack;

use crate::error::PackError;
use crate::pack::pack;

/// Converts the voxels of `dag` to a layout.
///
/// # Errors
/// Returns [`PackError`] if they have no packed form, or if there are too many columns for depths.
pub fn body_in(layout: Layout, dag: Dag) -> Result<LightBody, PackError> {
    Ok(match layout {
        Layout::Plain => LightBody::Plain(dag),
        Layout::Packed => LightBody::Packed(pack(&dag)?),
        Layout::Depths => LightBody::Depths(depths_of(&dag, dag.root_level)?),
    })
}

/// Returns the voxels of a file as a graph in the plain layout, for readers that support no other. Cost: none if they
/// already are one, otherwise that of [`unpack`] or [`graph_of_depths`].
///
/// # Errors
/// Returns [`FormatError::Packed`] or [`FormatError::Depths`] if the words are not valid, and [`FormatError::TooLarge`]
/// if the graph could be too large: a few bytes of either layout can represent any number of root cubes.
pub fn graph_of(body: &LightBody) -> Result<Cow<'_, Dag>, FormatError> {
    Ok(match body {
        LightBody::Plain(dag) => Cow::Borrowed(dag),
        LightBody::Packed(packed) => match unpack(packed) {
            Err(PackedError::TooLarge(limit)) => return Err(limit.into()),
            found => Cow::Owned(found?),
        },
        LightBody::Depths(depths) => {
            depths.validate()?;
            Cow::Owned(graph_of_depths(depths)?)
        }
    })
}
