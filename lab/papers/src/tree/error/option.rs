//! An option of a tree's bake that is out of its range.

use std::fmt::{self, Display};

/// An option of a tree's bake that has a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeOption {
    /// A term of the bias of a capture.
    CaptureBiasTerm,
    /// Nested squares of growing voxels.
    Rings,
    /// A region with its own depth.
    Region,
    /// Share of voxels that a lossy reduction may change.
    LossyShare,
}

/// The name in messages.
impl fmt::Display for TreeOption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::CaptureBiasTerm => "a term of the capture bias",
            Self::Rings => "the rings",
            Self::Region => "a region",
            Self::LossyShare => "the lossy share",
        })
    }
}

/// An option's value that is out of range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{option}: {value} is out of range; it must be {range}")]
pub struct OptionError {
    /// The option that has the value.
    pub option: TreeOption,
    /// The value that was given.
    pub value: String,
    /// The allowed range, as text.
    pub range: &'static str,
}

impl OptionError {
    /// Returns the error for `option` having the value `value`, which is not within `range`.
    pub fn new(option: TreeOption, value: impl Display, range: &'static str) -> Self {
        Self { option, value: value.to_string(), range }
    }
}
