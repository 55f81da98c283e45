//! Bytes -> [`ShadowFile`]. Nothing is allocated before the file's length has been found to justify it.

use std::path::Path;

use super::header::{Header, SECTIONS};
use super::sections::{read_file, split, u32_words};
use super::{FormatError, HEADER_BYTES, ShadowFile};
use crate::dag::Dag;
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
    /// Cost: time linear in `bytes`; memory for the decoded words and a byte a node word.
    ///
    /// # Errors
    /// What is wrong, with the values; any bytes that are not exactly one valid file are refused.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let header = Header::parse(bytes)?;
        let [top, nodes, slabs] = split(bytes, HEADER_BYTES, &SECTIONS, &header.sections)?;
        let dag = Dag {
            size: header.grid.size,
            root_level: header.root_level,
            top_dims: header.top_dims,
            top: u32_words(top),
            nodes: u32_words(nodes),
            slabs: slabs.as_chunks().0.iter().map(|&b| u64::from_le_bytes(b)).collect(),
        };
        dag.validate()?;
        Ok(Self { grid: header.grid, settings: header.settings, dag })
    }
}
