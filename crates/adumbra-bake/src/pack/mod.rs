//! Leaves of the quadtree of depths: columns sorted into few depths or planes, and written as half-words.

pub(crate) mod choose;
mod intervals;
pub(crate) mod leaf;
mod slant;
