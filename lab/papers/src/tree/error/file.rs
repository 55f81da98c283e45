//! Errors found in a tree file, with the values found.

use adumbra::FormatError;

use super::{SymmetricError, TreeError};
use crate::sections::SectionFault;

/// A fault of a tree file: what is wrong, where, and what to do about it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TreeFileError {
    /// A fault of the header, the sections or their checksums.
    #[error(transparent)]
    Sections(#[from] SectionFault),
    /// A region is not valid.
    #[error("region {index} has {value}, but must have {expected}; bake it again")]
    Region {
        /// Index in the list, from 0.
        index: usize,
        /// The value found.
        value: String,
        /// The values allowed.
        expected: String,
    },
    /// The words are not a tree, or not in the canonical order.
    #[error("the tree is not valid: {fault}; bake it again")]
    Tree {
        /// The fault found.
        #[from]
        fault: TreeError,
    },
    /// The symmetric body is not valid.
    #[error("the symmetric tree is not valid: {fault}; bake it again")]
    Symmetric {
        /// The fault found.
        #[from]
        fault: SymmetricError,
    },
}

impl From<FormatError> for TreeFileError {
    fn from(fault: FormatError) -> Self {
        Self::Sections(fault.into())
    }
}

impl TreeFileError {
    /// Returns the variant's name. It is stable across versions; the test vectors use it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Sections(fault) => fault.kind(),
            Self::Region { .. } => "Region",
            Self::Tree { .. } => "Tree",
            Self::Symmetric { .. } => "Symmetric",
        }
    }

    /// Returns the name of the fault in the voxels. It is stable across versions; the test vectors use it.
    pub fn fault(&self) -> Option<&'static str> {
        match self {
            Self::Sections(_) | Self::Region { .. } => None,
            Self::Tree { fault } => Some(match fault {
                TreeError::Depth { .. } => "Depth",
                TreeError::Length { .. } => "Length",
                TreeError::Word { .. } => "Word",
                TreeError::Index { .. } => "Index",
                TreeError::Order { .. } => "Order",
                TreeError::TooDeep { .. } => "TooDeep",
                TreeError::NotMerged { .. } => "NotMerged",
            }),
            Self::Symmetric { fault } => Some(match fault {
                SymmetricError::Depth { .. } => "Depth",
                SymmetricError::Length { .. } => "Length",
                SymmetricError::Flags { .. } => "Flags",
                SymmetricError::Root { .. } => "Root",
                SymmetricError::Cut { .. } => "Cut",
                SymmetricError::NotMerged { .. } => "NotMerged",
                SymmetricError::Mask { .. } => "Mask",
                SymmetricError::Pointer { .. } => "Pointer",
                SymmetricError::TooDeep { .. } => "TooDeep",
                SymmetricError::Unreached { .. } => "Unreached",
            }),
        }
    }
}
