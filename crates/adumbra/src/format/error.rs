//! What can be wrong with a shadow file, with the values that are.

use crate::dag::GraphError;

/// What is wrong with a shadow file: what, where, and what to do about it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The file is something else.
    #[error(
        "not a shadow file: it begins with \"{}\" instead of \"ADUMBRA\\n\"; give a file that `bake` has written, and copy it as binary",
        found.escape_ascii()
    )]
    Magic {
        /// The first bytes, at most eight.
        found: Vec<u8>,
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
        /// "header", "top", "nodes" or "slabs".
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
        /// "top", "nodes" or "slabs".
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
        /// "top", "nodes" or "slabs".
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
}

impl FormatError {
    /// The variant's name, stable across versions; test vectors use it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Magic { .. } => "Magic",
            Self::FutureVersion { .. } => "FutureVersion",
            Self::Truncated { .. } => "Truncated",
            Self::TrailingBytes { .. } => "TrailingBytes",
            Self::HeaderChecksum { .. } => "HeaderChecksum",
            Self::SectionChecksum { .. } => "SectionChecksum",
            Self::HeaderField { .. } => "HeaderField",
            Self::SectionBounds { .. } => "SectionBounds",
            Self::Padding { .. } => "Padding",
            Self::Graph { .. } => "Graph",
        }
    }
}
