//! The in-memory form of a file's voxels: a [quadtree of switch depths](depths).

mod composition;
pub mod depths;
mod roots;

pub use composition::Composition;
pub use roots::{LEAF_NODE_LEVEL, MAX_ROOT_LEVEL, top_dims};
