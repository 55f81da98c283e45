//! Why a graph cannot be baked, read or written.

use std::path::PathBuf;

use adumbra::IoError;

use crate::dag::file_error::DagFileError;
use crate::dag::pack_error::PackError;

/// All errors of graphs.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused to read or write something.
    #[error(transparent)]
    Io(#[from] IoError),
    /// The bake failed.
    #[error(transparent)]
    Bake(#[from] adumbra_bake::Error),
    /// A graph has no packed form.
    #[error(transparent)]
    Pack(#[from] PackError),
    /// A setting is out of its range, or there is no sun.
    #[error(transparent)]
    Reader(Box<adumbra::Error>),
    /// A file is not valid.
    #[error("{path:?}: {source}", path = path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// The fault found.
        source: Box<DagFileError>,
    },
}

impl From<adumbra::Error> for Error {
    /// Maps the faults of a file to [`Error::Io`] and [`Error::Format`], whichever part of the reader found
    /// them.
    fn from(error: adumbra::Error) -> Self {
        match error {
            adumbra::Error::Io(error) => Self::Io(error),
            adumbra::Error::Format { path: Some(path), source } => {
                Self::Format { path, source: Box::new((*source).into()) }
            }
            error => Self::Reader(Box::new(error)),
        }
    }
}

/// Result type of this module.
pub type Result<T, E = Error> = std::result::Result<T, E>;
