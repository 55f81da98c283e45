//! A file of either kind, told apart by its first bytes.

use std::path::Path;

use super::fields::{LIGHT, TREE};
use super::sections::read_file;
use super::{FormatError, HEADER_BYTES, ShadowFile, TreeFile, header, tree};
use crate::error::{Error, Result};

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub enum AnyFile {
    /// A light-aligned graph.
    Light(ShadowFile),
    /// A world-aligned tree.
    Tree(TreeFile),
}

impl AnyFile {
    /// Bytes of the file.
    pub fn encoded_len(&self) -> u64 {
        match self {
            Self::Light(file) => file.encoded_len(),
            Self::Tree(file) => file.encoded_len(),
        }
    }

    /// Reads and checks the file at `path`; the header first.
    ///
    /// # Errors
    /// [`Error::Io`] where the system refuses, [`Error::Format`] where the file is not valid.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        // The longer header of the two.
        let bytes = read_file(path, HEADER_BYTES, |front| {
            Ok(if is_tree(front)? {
                tree::Header::parse(front)?.file_bytes()
            } else {
                header::Header::parse(front)?.file_bytes()
            })
        })?;
        Self::parse(&bytes).map_err(|source| Error::Format { path: path.to_owned(), source })
    }

    /// Decodes and checks a whole file.
    ///
    /// # Errors
    /// What is wrong, with the values, as the reader of the kind says it.
    pub fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        Ok(if is_tree(bytes)? {
            Self::Tree(TreeFile::parse(bytes)?)
        } else {
            Self::Light(ShadowFile::from_bytes(bytes)?)
        })
    }
}

/// Whether the bytes begin as a tree file does; what begins as both do is taken for the other one.
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
