//! Decoding of a [`ShadowFile`]. Nothing is allocated until the file's length has been found to justify it.

use std::path::Path;

use crate::error::FormatError;
use crate::error::{Error, Result};
use crate::file::header::{Header, SECTIONS};
use crate::file::sections::{read_file, split};
use crate::file::{HEADER_BYTES, ShadowFile, body};

impl ShadowFile {
    /// Reads and validates the file at `path`.
    ///
    /// The header is read first, so a large file of another kind is refused without being read.
    ///
    /// # Errors
    /// Returns [`Error::Io`] if the operating system fails to read the file, and [`Error::Format`] if the file is not
    /// valid.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let bytes = read_file(path, HEADER_BYTES, |front| Ok(Header::parse(front)?.file_bytes()))?;
        Self::from_bytes(&bytes)
            .map_err(|source| Error::Format { path: path.to_owned(), source: Box::new(source) })
    }

    /// Decodes and validates a whole file.
    ///
    /// Cost: time linear in `bytes`; memory for the decoded words and at most one byte per node word.
    ///
    /// # Errors
    /// Returns the fault with the values found. All bytes that are not exactly one valid file are refused.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let header = Header::parse(bytes)?;
        let sections = split(bytes, HEADER_BYTES, &SECTIONS, &header.sections)?;
        let tree = body::parse(&header, sections);
        tree.validate()?;
        Ok(Self::new(header.grid, header.settings, tree))
    }
}
