//! Storage of what is built: nodes and shapes without duplicates, in memory or in pages on disk, and their canonical
//! numbering.

mod canonical;
pub(crate) mod graph;
pub(crate) mod paged;
pub(crate) mod shapes;

pub(crate) use canonical::PagedDag;
pub use graph::{NodeState, NodeStore};
