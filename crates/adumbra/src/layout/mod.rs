//! The in-memory form of a file's voxels: a [quadtree of switch depths](depths).

pub mod depths;
