//! Why bytes are not a graph file.

use adumbra::FormatError;

use crate::dag::packed::PackedError;
use crate::dag::plain::GraphError;
use crate::dag::too_large::TooLarge;
use crate::sections::SectionFault;

/// A fault of a graph file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DagFileError {
    /// A fault of the header or the sections.
    #[error(transparent)]
    Sections(#[from] SectionFault),
    /// The graph cannot be traversed, or is not canonical.
    #[error("the graph is not valid: {fault}; bake it again")]
    Graph {
        /// The fault in the graph.
        #[from]
        fault: GraphError,
    },
    /// The packed graph cannot be traversed.
    #[error("the packed graph is not valid: {fault}; bake it again")]
    Packed {
        /// The fault in the graph.
        #[from]
        fault: PackedError,
    },
    /// The file is valid, but its conversion to another layout would be too large.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
}

impl From<FormatError> for DagFileError {
    fn from(fault: FormatError) -> Self {
        Self::Sections(fault.into())
    }
}

impl DagFileError {
    /// Returns the variant's name. It is stable across versions and is used by the test vectors.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Sections(fault) => fault.kind(),
            Self::Graph { .. } => "Graph",
            Self::Packed { .. } => "Packed",
            Self::TooLarge(_) => "TooLarge",
        }
    }

    /// Returns the name of the fault in the voxels, if that is where the fault is.
    pub fn fault(&self) -> Option<&'static str> {
        match self {
            Self::Graph { fault } => Some(fault.kind()),
            Self::Packed { fault } => Some(fault.kind()),
            Self::Sections(_) | Self::TooLarge(_) => None,
        }
    }
}
