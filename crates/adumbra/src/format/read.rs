//! Bytes -> [`ShadowFile`]. Nothing is allocated before the file's length has been found to justify it.

use std::path::Path;

use super::header::{Header, SECTIONS};
use super::sections::{read_file, split};
use super::{FormatError, HEADER_BYTES, LightBody, ShadowFile};
use crate::error::{Error, Result};

impl ShadowFile {
    /// Reads and checks the file at `path`.
    ///
    /// The header is read first, so a large file of another kind is refused without being read.
    ///
    /// # Errors
    /// [`Error::Io`] where the system refuses, [`Error::Format`] where the file is not valid.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let bytes = read_file(path, HEADER_BYTES, |front| Ok(Header::parse(front)?.file_bytes()))?;
        Self::from_bytes(&bytes).map_err(|source| Error::Format { path: path.to_owned(), source })
    }

    /// Decodes and checks a whole file.
    ///
    /// Cost: time linear in `bytes`; memory for the decoded words and at most a byte a node word.
    ///
    /// # Errors
    /// What is wrong, with the values; any bytes that are not exactly one valid file are refused.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let header = Header::parse(bytes)?;
        let sections = split(bytes, HEADER_BYTES, &SECTIONS, &header.sections)?;
        let body = LightBody::parse(&header, sections);
        body.validate()?;
        Ok(Self { grid: header.grid, settings: header.settings, body })
    }
}
