//! The graphs of the 2014 paper: voxels of a light-aligned grid as a directed acyclic graph, in which equal
//! parts are stored once.
//!
//! Source: Sintorn, Kämpe, Olsson, Assarsson, *Compact Precomputed Voxelized Shadows*, 2014. The product
//! stores the depths at which columns switch instead, which takes fewer bytes and fewer words per look-up.
//!
//! | module | contents |
//! |---|---|
//! | [`plain`] | the graph as a bake builds it, in words of 32 bits |
//! | [`packed`] | the same graph in units of 16 bits, about a third of the bytes |
//! | `file`, `header`, `body` | the graph file, `spec/adumbra-dag.md` |
//! | `query`, `taps`, `descend`, `trail` | look-ups on the CPU |
//! | `quadtree` | leaf masks of the product's quadtree |
//! | [`build`] | bakes a graph from the columns of a scene, and converts graphs |

mod body;
pub mod build;
pub mod composition;
mod descend;
mod error;
mod file;
mod file_error;
mod header;
mod layout;
mod leaf_masks;
mod pack_error;
pub mod packed;
pub mod plain;
mod quadtree;
mod query;
pub mod roots;
mod taps;
mod too_large;
mod top_error;
mod trail;

pub use body::DagBody;
pub use error::{Error, Result};
pub use file::DagFile;
pub use file_error::DagFileError;
pub use header::{DAG_HEADER_BYTES, DAG_MAGIC, Header};
pub use layout::DagLayout;
pub use leaf_masks::LeafMasks;
pub use pack_error::PackError;
pub use query::DagQuery;
pub use too_large::{MAX_CONVERTED_DEPTH, MAX_CONVERTED_ROOTS, TooLarge};
pub use top_error::TopError;
pub use trail::Trail;
