//! The parts of a file: their entries in tables, checksums and words, and reading a file header first.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::{Error, FormatError, IoError, Result};

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

/// Returns the bytes of a section, after comparing them with its checksum.
///
/// # Errors
/// Returns [`FormatError::Truncated`] or [`FormatError::SectionChecksum`].
pub(crate) fn checked(
    bytes: &[u8],
    section: Section,
    name: impl Fn() -> String,
) -> Result<&[u8], FormatError> {
    let found = usize::try_from(section.end()).ok().and_then(|end| bytes.get(section.offset as usize..end));
    let Some(found) = found else {
        let (needed, have) = (section.end(), bytes.len() as u64);
        return Err(FormatError::Truncated { what: name().into(), needed, have });
    };
    let (stored, computed) = (section.checksum, crc32fast::hash(found));
    if stored == computed {
        return Ok(found);
    }
    Err(FormatError::SectionChecksum { section: name().into(), stored, computed })
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
    let whole = file_bytes(&bytes).map_err(|fault| Error::in_file(path, fault))?;
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
