//! A file of either kind, distinguished by its first bytes.

use std::io::{self, Write};
use std::path::Path;

use adumbra::file::fields::{LIGHT, TREE};
use adumbra::file::sections::read_file;
use adumbra::file::{HEADER_BYTES, Header};
use adumbra::{FormatError, ShadowFile, Sun};

use super::TreeFile;
use super::header::Header as TreeHeader;
use crate::error::{Error, Result, TreeFileError};

/// The contents of a file.
#[derive(Clone, Debug, PartialEq)]
pub enum AnyFile {
    /// A light-aligned graph.
    Light(ShadowFile),
    /// A world-aligned tree.
    Tree(TreeFile),
}

impl AnyFile {
    /// Size of the file in bytes.
    pub fn encoded_len(&self) -> u64 {
        match self {
            Self::Light(file) => file.encoded_len(),
            Self::Tree(file) => file.encoded_len(),
        }
    }

    /// The sun that the file was baked for.
    pub fn sun(&self) -> Sun {
        match self {
            Self::Light(file) => file.sun(),
            Self::Tree(file) => file.sun(),
        }
    }

    /// Whether the bake treated masked materials as opaque.
    pub fn ignores_alpha(&self) -> bool {
        match self {
            Self::Light(file) => file.ignores_alpha(),
            Self::Tree(file) => file.ignores_alpha(),
        }
    }

    /// Reads and checks the file at `path`, header first.
    ///
    /// # Errors
    /// Returns [`Error::Io`] if the operating system refuses the read, and [`Error::Format`] if the file is not valid.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        // The larger of the two header sizes.
        let bytes = read_file(path, HEADER_BYTES, |front| {
            Ok(if is_tree(front)? {
                TreeHeader::parse(front)?.file_bytes()
            } else {
                Header::parse(front)?.file_bytes()
            })
        })?;
        Self::from_bytes(&bytes)
            .map_err(|source| Error::Format { path: path.to_owned(), source: Box::new(source) })
    }

    /// Writes the file to `out` and returns the number of bytes.
    ///
    /// # Errors
    /// Returns the errors of `out`, and [`std::io::ErrorKind::InvalidData`] if the contents are not valid.
    pub fn write_to(&self, out: &mut impl Write) -> io::Result<u64> {
        match self {
            Self::Light(file) => file.write_to(out),
            Self::Tree(file) => file.write_to(out),
        }
    }

    /// Decodes and checks a whole file.
    ///
    /// # Errors
    /// Returns the fault found, with the values, as the reader of that kind of file reports it.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, TreeFileError> {
        Ok(if is_tree(bytes)? {
            Self::Tree(TreeFile::from_bytes(bytes)?)
        } else {
            Self::Light(ShadowFile::from_bytes(bytes)?)
        })
    }
}

/// Whether the bytes begin like a tree file. A prefix common to both kinds counts as light-aligned.
fn is_tree(bytes: &[u8]) -> Result<bool, FormatError> {
    let start = &bytes[..bytes.len().min(LIGHT.magic.len())];
    if LIGHT.magic.starts_with(start) {
        Ok(false)
    } else if TREE.magic.starts_with(start) {
        Ok(true)
    } else {
        let expected = "\"ADUMBRA\\n\" or \"ADUMTREE\"";
        Err(FormatError::Magic { found: start.to_vec(), expected })
    }
}
