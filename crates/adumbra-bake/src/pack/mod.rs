//! Encodes the quadtree of depths as half-words: leaves sorted into few depths or planes, and the order of shapes.

pub(crate) mod choose;
pub(crate) mod encode;
mod intervals;
pub(crate) mod leaf;
mod slant;
