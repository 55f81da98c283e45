//! Triangles, binned by root block and projected onto the light's plane.

pub(crate) mod adjacency;
pub(crate) mod casters;
pub(crate) mod cluster;
pub(crate) mod corners;
pub(crate) mod depth;
pub(crate) mod opacity;
pub(crate) mod project;
pub(crate) mod surface;
