//! Columns: the first surface of each, and the interval in which it may switch from lit to shadowed.

mod block;
pub(crate) mod capture;
pub(crate) mod crossings;
pub(crate) mod limit;
pub(crate) mod masked;
pub(crate) mod rules;
pub(crate) mod seams;

pub use block::BlockColumns;
pub(crate) use block::{BLOCK_SIDE, Columns};
