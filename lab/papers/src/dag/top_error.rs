//! Faults of a graph's top grid and sizes, for the layouts `plain` and `packed`.

use crate::dag::roots::{LEAF_NODE_LEVEL, MAX_ROOT_LEVEL, top_dims};

/// A fault of a graph's top grid or size.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TopError {
    /// The root level is out of range.
    #[error("root level {root_level} is not from {LEAF_NODE_LEVEL} to {MAX_ROOT_LEVEL}")]
    RootLevel {
        /// The root level found.
        root_level: u32,
    },
    /// The top grid's dimensions do not follow from the size and the root level.
    #[error("top grid of {found:?} roots, but the size and the root level require {expected:?}")]
    TopDims {
        /// The dimensions found.
        found: [u32; 3],
        /// The dimensions that follow from the size.
        expected: [u32; 3],
    },
    /// The top grid's length in words does not match its columns and roots.
    #[error("top of {found} words, but its columns and roots require {expected}")]
    TopLength {
        /// The number of words found.
        found: u64,
        /// The number of words required.
        expected: u128,
    },
    /// There are more items than pointers can address.
    #[error("{count} {what}, but pointers can address at most {limit}")]
    TooMany {
        /// "node words", "units" or "leaf masks".
        what: &'static str,
        /// The number found.
        count: u64,
        /// The largest allowed number.
        limit: u64,
    },
}

impl TopError {
    /// Returns the variant's name, which is stable across versions.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::RootLevel { .. } => "RootLevel",
            Self::TopDims { .. } => "TopDims",
            Self::TopLength { .. } => "TopLength",
            Self::TooMany { .. } => "TooMany",
        }
    }
}

/// Checks that the root level is in range, and that the top grid's dimensions match the size.
pub(super) fn check_dims(size: [u32; 3], root_level: u32, found: [u32; 3]) -> Result<(), TopError> {
    if !(LEAF_NODE_LEVEL..=MAX_ROOT_LEVEL).contains(&root_level) {
        return Err(TopError::RootLevel { root_level });
    }
    let expected = top_dims(size, root_level);
    if found == expected { Ok(()) } else { Err(TopError::TopDims { found, expected }) }
}

/// Checks that there are no more items than pointers can address.
pub(super) fn check_count(what: &'static str, count: u64, limit: u64) -> Result<(), TopError> {
    if count > limit { Err(TopError::TooMany { what, count, limit }) } else { Ok(()) }
}
