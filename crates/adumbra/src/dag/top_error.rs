//! What may be wrong with a graph's top grid and its sizes, in either layout.

use super::{Dag, MAX_ROOT_LEVEL, SLAB_NODE_LEVEL};

/// A fault of the top grid, or of a size.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TopError {
    /// The root level is out of range.
    #[error("root level {root_level} is not from {SLAB_NODE_LEVEL} to {MAX_ROOT_LEVEL}")]
    RootLevel {
        /// The level given.
        root_level: u32,
    },
    /// The top grid's dimensions do not follow from the size and the root level.
    #[error("top grid of {found:?} roots, but the size and the root level ask for {expected:?}")]
    TopDims {
        /// What it says.
        found: [u32; 3],
        /// What follows from the size.
        expected: [u32; 3],
    },
    /// The top has not as many words as its columns and roots need.
    #[error("top of {found} words, but its columns and roots ask for {expected}")]
    TopLength {
        /// Words there are.
        found: u64,
        /// Words there should be.
        expected: u128,
    },
    /// More than pointers can tell apart.
    #[error("{count} {what}, but a pointer can name at most {limit}")]
    TooMany {
        /// "node words", "units" or "slabs".
        what: &'static str,
        /// How many there are.
        count: u64,
        /// The most there may be.
        limit: u64,
    },
}

impl TopError {
    /// The variant's name, stable across versions.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::RootLevel { .. } => "RootLevel",
            Self::TopDims { .. } => "TopDims",
            Self::TopLength { .. } => "TopLength",
            Self::TooMany { .. } => "TooMany",
        }
    }
}

/// That the root level is one, and the top grid's dimensions are those of the size.
pub(super) fn check_dims(size: [u32; 3], root_level: u32, found: [u32; 3]) -> Result<(), TopError> {
    if !(SLAB_NODE_LEVEL..=MAX_ROOT_LEVEL).contains(&root_level) {
        return Err(TopError::RootLevel { root_level });
    }
    let expected = Dag::top_dims_covering(size, root_level);
    if found == expected { Ok(()) } else { Err(TopError::TopDims { found, expected }) }
}

/// That there are no more of something than pointers can name.
pub(super) fn check_count(what: &'static str, count: u64, limit: u64) -> Result<(), TopError> {
    if count > limit { Err(TopError::TooMany { what, count, limit }) } else { Ok(()) }
}
