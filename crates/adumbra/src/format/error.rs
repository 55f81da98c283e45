//! What can be wrong with a file, light-aligned or tree, with the values that are.

use crate::dag::packed::PackedError;
use crate::dag::{GraphError, TooLarge};
use crate::hierarchy::HierarchyError;
use crate::tree::TreeError;
use crate::tree::symmetric::SymmetricError;

/// What is wrong with a shadow file: what, where, and what to do about it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The file is something else.
    #[error(
        "not a shadow file: it begins with \"{}\" instead of {expected}; give a file that `bake` has written, and copy it as binary",
        found.escape_ascii()
    )]
    Magic {
        /// The first bytes, at most eight.
        found: Vec<u8>,
        /// What they should be, as shown.
        expected: &'static str,
    },
    /// The file is one of ours, but of the other kind.
    #[error("this is a {found}, but a {needed} is needed here; give one, or bake the scene as one")]
    OtherKind {
        /// What the file is.
        found: &'static str,
        /// What was asked for.
        needed: &'static str,
    },
    /// The file is from a later program.
    #[error(
        "version {version} of the format, but this program reads up to version {supported}; update the program, or bake the scene again with this one"
    )]
    FutureVersion {
        /// The file's version.
        version: u32,
        /// The latest version that is read.
        supported: u32,
    },
    /// The file ends too early.
    #[error(
        "cut off in its {what}: {needed} bytes are needed, but the file has {have}; copy it again, or bake it again"
    )]
    Truncated {
        /// "header", or the section's name.
        what: &'static str,
        /// Bytes that the file must have up to the end of that part.
        needed: u64,
        /// Bytes it has.
        have: u64,
    },
    /// The file goes on behind its last section.
    #[error("goes on behind its end at byte {end}; copy it again, or bake it again")]
    TrailingBytes {
        /// Where it should end.
        end: u64,
    },
    /// The header is damaged.
    #[error(
        "the header is damaged: its checksum is {computed:#010x} instead of {stored:#010x}; copy the file again, or bake it again"
    )]
    HeaderChecksum {
        /// As stored.
        stored: u32,
        /// As computed from the bytes.
        computed: u32,
    },
    /// A section is damaged.
    #[error(
        "the section {section} is damaged: its checksum is {computed:#010x} instead of {stored:#010x}; copy the file again, or bake it again"
    )]
    SectionChecksum {
        /// The section's name.
        section: &'static str,
        /// As stored.
        stored: u32,
        /// As computed from the bytes.
        computed: u32,
    },
    /// A field of the header has a value that means nothing.
    #[error("the header's {field} is {value}, but must be {expected}; bake it again")]
    HeaderField {
        /// The field's name in the specification.
        field: &'static str,
        /// The value found.
        value: String,
        /// What is allowed.
        expected: String,
    },
    /// The section table contradicts the rest of the header.
    #[error("the section {section} has {field} {value}, but must have {expected}; bake it again")]
    SectionBounds {
        /// The section's name.
        section: &'static str,
        /// "offset" or "length".
        field: &'static str,
        /// The value found.
        value: u64,
        /// What is allowed.
        expected: String,
    },
    /// A byte between two sections is not zero.
    #[error(
        "byte {offset} lies between two sections and is {value:#04x}, but must be 0; copy the file again, or bake it again"
    )]
    Padding {
        /// Where the byte is.
        offset: u64,
        /// What it is.
        value: u8,
    },
    /// The graph cannot be walked, or is not canonical.
    #[error("the graph is not valid: {fault}; bake it again")]
    Graph {
        /// What is wrong with it.
        #[from]
        fault: GraphError,
    },
    /// The packed graph cannot be walked.
    #[error("the packed graph is not valid: {fault}; bake it again")]
    Packed {
        /// What is wrong with it.
        #[from]
        fault: PackedError,
    },
    /// The hierarchy cannot be looked up in.
    #[error("the hierarchy is not valid: {fault}; bake it again")]
    Hierarchy {
        /// What is wrong with it.
        #[from]
        fault: HierarchyError,
    },
    /// The file is valid, but is not converted to another layout.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// A region of a tree means nothing.
    #[error("region {index} has {value}, but must have {expected}; bake it again")]
    Region {
        /// Its place in the list, from 0.
        index: usize,
        /// What was found.
        value: String,
        /// What is allowed.
        expected: String,
    },
    /// The words are not a tree, or not in its one order.
    #[error("the tree is not valid: {fault}; bake it again")]
    Tree {
        /// What is wrong with it.
        #[from]
        fault: TreeError,
    },
    /// The symmetric body is not valid.
    #[error("the symmetric tree is not valid: {fault}; bake it again")]
    Symmetric {
        /// What is wrong with it.
        #[from]
        fault: SymmetricError,
    },
}

impl FormatError {
    /// The variant's name, stable across versions; test vectors use it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Magic { .. } => "Magic",
            Self::OtherKind { .. } => "OtherKind",
            Self::FutureVersion { .. } => "FutureVersion",
            Self::Truncated { .. } => "Truncated",
            Self::TrailingBytes { .. } => "TrailingBytes",
            Self::HeaderChecksum { .. } => "HeaderChecksum",
            Self::SectionChecksum { .. } => "SectionChecksum",
            Self::HeaderField { .. } => "HeaderField",
            Self::SectionBounds { .. } => "SectionBounds",
            Self::Padding { .. } => "Padding",
            Self::Graph { .. } => "Graph",
            Self::Packed { .. } => "Packed",
            Self::Hierarchy { .. } => "Hierarchy",
            Self::TooLarge(_) => "TooLarge",
            Self::Region { .. } => "Region",
            Self::Tree { .. } => "Tree",
            Self::Symmetric { .. } => "Symmetric",
        }
    }

    /// The name of what is wrong with a graph or a tree, stable across versions; test vectors use it.
    pub fn fault(&self) -> Option<&'static str> {
        match self {
            Self::Graph { fault } => Some(fault.kind()),
            Self::Packed { fault } => Some(fault.kind()),
            Self::Hierarchy { fault } => Some(fault.kind()),
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
            _ => None,
        }
    }
}
