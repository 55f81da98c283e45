//! The fast builder: a quadtree descent whose cost grows with the silhouettes.

mod block;
mod classify;
pub(crate) mod descent;
mod gather;
mod leaf;
