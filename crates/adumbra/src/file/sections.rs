//! The parts of a file: their entries in tables, their words, and reading a file header first.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::FormatError;
use crate::error::{Error, IoError, Result};

/// Number of bytes encoded at a time.
const CHUNK_BYTES: usize = 1 << 16;

/// An entry of the section table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Section {
    /// Offset of the section's first byte in the file.
    pub offset: u64,
    /// Length in bytes.
    pub length: u64,
    /// CRC-32 of the section's bytes.
    pub checksum: u32,
}

impl Section {
    /// Returns the offset in the file at which the section ends.
    pub fn end(&self) -> u64 {
        self.offset.saturating_add(self.length)
    }
}

/// Returns the error for an entry of the section table that contradicts the rest of the header.
pub fn bounds(
    section: impl Into<Cow<'static, str>>,
    field: &'static str,
    value: u64,
    expected: impl Into<String>,
) -> FormatError {
    FormatError::SectionBounds { section: section.into(), field, value, expected: expected.into() }
}

/// Reads the file at `path`. `file_bytes` receives the first `header_bytes` bytes, or all of a shorter file,
/// and returns the length of the file. So a large file of another kind is refused without being read.
///
/// # Errors
/// Returns [`Error::Io`] if the operating system fails to read the file, and [`Error::Format`] with an error
/// of `file_bytes`.
pub fn read_file(
    path: &Path,
    header_bytes: usize,
    file_bytes: impl FnOnce(&[u8]) -> Result<u64, FormatError>,
) -> Result<Vec<u8>> {
    let mut file = File::open(path).map_err(IoError::at("read", path))?;
    let mut bytes = Vec::new();
    (&mut file).take(header_bytes as u64).read_to_end(&mut bytes).map_err(IoError::at("read", path))?;
    let whole = file_bytes(&bytes)
        .map_err(|source| Error::Format { path: Some(path.to_owned()), source: Box::new(source) })?;
    // Reads one byte more than there should be, to detect trailing bytes.
    let rest = whole.saturating_sub(bytes.len() as u64).saturating_add(1);
    let length = file.metadata().map_or(0, |found| found.len());
    bytes.reserve_exact(rest.min(length) as usize);
    file.take(rest).read_to_end(&mut bytes).map_err(IoError::at("read", path))?;
    Ok(bytes)
}

/// Decodes the little-endian words of a section that consists of whole words.
pub fn u32_words(bytes: &[u8]) -> Vec<u32> {
    bytes.as_chunks().0.iter().map(|&b| u32::from_le_bytes(b)).collect()
}

/// Encodes `words` in little-endian, in pieces of 64 KiB.
pub fn u32_chunks(words: &[u32]) -> impl Iterator<Item = Vec<u8>> {
    words.chunks(CHUNK_BYTES / 4).map(|c| c.iter().flat_map(|w| w.to_le_bytes()).collect())
}
