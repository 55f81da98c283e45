//! Look-ups in a tree.

mod penumbra;
mod plan;
mod receiver;
mod tree;

pub use penumbra::PenumbraQuery;
pub use plan::PlanLevels;
pub use receiver::{MAX_HEIGHT_CELLS, NORMAL_ONE, TreeReceiver};
pub use tree::{KERNEL_SIDES, TreeQuery, Weights};
