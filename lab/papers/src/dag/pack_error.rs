//! Why a graph has no packed form.

use crate::dag::packed::MAX_UNITS;
use crate::dag::plain::{GraphError, GraphPlace};
use crate::dag::too_large::TooLarge;

/// The reason why a graph has no packed form.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PackError {
    /// The graph itself is not valid.
    #[error("the graph is not valid: {0}")]
    Graph(#[from] GraphError),
    /// A lit voxel is behind a shadowed voxel.
    #[error(
        "{place}, of level {level}, has a column that is lit behind a shadowed voxel, which only the plain layout can \
         store; use the plain layout"
    )]
    NotMonotone {
        /// The node, or the root cube.
        place: GraphPlace,
        /// Its level.
        level: u32,
    },
    /// More units than pointers can address.
    #[error("{units} units of nodes, but the packed layout holds at most {MAX_UNITS}; use the plain layout")]
    TooLarge {
        /// A lower bound on the number of units.
        units: u64,
    },
    /// The grid is too large for the layout asked for.
    #[error(transparent)]
    Grid(#[from] TooLarge),
}
