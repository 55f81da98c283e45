//! Errors of a tree: of its bake, its file and its textures.

mod file;
mod option;
mod texture;
mod tree;
mod words;

use std::path::PathBuf;

use adumbra::{IoError, RangeError};

pub use file::TreeFileError;
pub use option::{OptionError, TreeOption};
pub use texture::TextureError;
pub use tree::{LightTreeError, SymmetricError, TreeError};
pub use words::WordsError;

/// All errors of a tree.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused to read or write something.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A value is out of its range.
    #[error(transparent)]
    Range(#[from] RangeError),
    /// An option of a tree is out of its range.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// The bake failed.
    #[error(transparent)]
    Bake(#[from] adumbra_bake::Error),
    /// A sun or bytes without a path are not valid.
    #[error(transparent)]
    Reader(Box<adumbra::Error>),
    /// A file, world-aligned or light-aligned, is not valid.
    #[error("{path:?}: {source}", path = path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// The fault found.
        source: Box<TreeFileError>,
    },
    /// A texture of words is not an intact export, or the words do not fit into textures.
    #[error("{path:?}: {source}", path = path.display())]
    WordTexture {
        /// The file of the page.
        path: PathBuf,
        /// The fault found.
        source: TextureError,
    },
    /// A file cannot be represented as words, or words cannot be turned into a file.
    #[error("{path:?}: {source}", path = path.display())]
    Words {
        /// The file, or the first page of the words.
        path: PathBuf,
        /// The fault found.
        source: WordsError,
    },
}

impl Error {
    /// The error of a cancelled bake.
    pub(crate) fn interrupted() -> Self {
        adumbra_bake::Error::Interrupted.into()
    }

    /// The error for `what` having more words than pointers can address.
    pub(crate) fn too_many_words(what: &'static str) -> Self {
        adumbra_bake::Error::TooManyWords { what }.into()
    }

    /// The error for `what` needing more memory than allowed.
    pub(crate) fn memory(what: &'static str, needed_bytes: u64, limit_bytes: u64) -> Self {
        adumbra_bake::Error::MemoryLimit { what, needed_bytes, limit_bytes }.into()
    }
}

impl From<adumbra::Error> for Error {
    /// Maps the faults of a file to [`Error::Io`] and [`Error::Format`], whichever part of the reader found
    /// them.
    fn from(error: adumbra::Error) -> Self {
        match error {
            adumbra::Error::Io(error) => Self::Io(error),
            adumbra::Error::Range(error) => Self::Range(error),
            adumbra::Error::Format { path: Some(path), source } => {
                Self::Format { path, source: Box::new((*source).into()) }
            }
            error => Self::Reader(Box::new(error)),
        }
    }
}

/// Result type used across the crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
