//! Why a file cannot be represented as words, or words cannot be turned into a file.

use adumbra::FormatError;

use crate::dag::DagFileError;
use crate::dag::PackError;

use super::{LightTreeError, TreeError};

/// Why a file cannot be represented as words, or words and a header do not make a file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WordsError {
    /// The header, or the file to be written, is not valid.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The graph file is not valid.
    #[error(transparent)]
    Graph(#[from] DagFileError),
    /// The words are not a tree.
    #[error("the words are not a tree: {0}; export it again")]
    Tree(#[from] TreeError),
    /// The graph and the tree cannot be converted into each other.
    #[error(transparent)]
    Light(#[from] LightTreeError),
    /// The graph has no packed form.
    #[error(transparent)]
    Pack(#[from] PackError),
    /// The graph stores equal nodes separately, which the words of a tree cannot represent.
    #[error(
        "its graph of {found} words and leaf masks is not canonical: its canonical form has {canonical}; only files that `bake` has written can be exported"
    )]
    NotCanonical {
        /// Number of words and leaf masks of the graph.
        found: usize,
        /// Number of words and leaf masks of the graph that the tree converts back to.
        canonical: usize,
    },
    /// The words make another file than the header describes.
    #[error(
        "the words make a different file from the one that their header describes (byte {byte} of the header differs); export it again"
    )]
    Differs {
        /// The first byte of the header that differs.
        byte: usize,
    },
}
