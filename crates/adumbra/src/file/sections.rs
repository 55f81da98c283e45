//! The sections after a header: their offsets, padding and checksums, and reading and writing files that
//! consist of them.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use crate::error::FormatError;
use crate::error::{Error, IoError, Result};

/// Sections begin at multiples of this many bytes.
const ALIGNMENT: u64 = 16;
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

/// Places sections of these lengths after a header. Their checksums are set to 0.
pub fn lay_out<const N: usize>(header_bytes: usize, lengths: [u64; N]) -> [Section; N] {
    let mut end = header_bytes as u64;
    lengths.map(|length| {
        let section = Section { offset: align(end), length, checksum: 0 };
        end = section.end();
        section
    })
}

fn align(offset: u64) -> u64 {
    offset.checked_next_multiple_of(ALIGNMENT).unwrap_or(u64::MAX)
}

/// Checks that sections have the offsets that [`lay_out`] gives them, and valid lengths. `expected` is called
/// with a section's index and length, and returns the required length as text if the length is wrong.
///
/// # Errors
/// Returns [`FormatError::SectionBounds`] with the first section that has a wrong offset or length.
pub fn check_sections<const N: usize>(
    header_bytes: usize,
    names: &[&'static str; N],
    sections: &[Section; N],
    expected: impl Fn(usize, u64) -> Option<String>,
) -> Result<(), FormatError> {
    let mut end = header_bytes as u64;
    for (i, s) in sections.iter().enumerate() {
        if s.offset != align(end) {
            return Err(bounds(names[i], "offset", s.offset, align(end).to_string()));
        }
        if let Some(expected) = expected(i, s.length) {
            return Err(bounds(names[i], "length", s.length, expected));
        }
        end = s.end();
    }
    Ok(())
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

/// Returns the bytes of each section, after checking padding, lengths and checksums. The order of the
/// sections must have been checked with the header.
///
/// # Errors
/// Returns the fault with the values found.
pub fn split<'a, const N: usize>(
    bytes: &'a [u8],
    header_bytes: usize,
    names: &[&'static str; N],
    sections: &[Section; N],
) -> Result<[&'a [u8]; N], FormatError> {
    let have = bytes.len() as u64;
    let mut parts = [&[][..]; N];
    let mut gap_from = header_bytes;
    for ((part, section), &what) in parts.iter_mut().zip(sections).zip(names) {
        // A section within `bytes` has offsets that fit `usize`.
        let (from, to) = (section.offset as usize, section.end() as usize);
        let (true, Some(gap), Some(found)) =
            (section.end() <= have, bytes.get(gap_from..from), bytes.get(from..to))
        else {
            return Err(FormatError::Truncated { what: what.into(), needed: section.end(), have });
        };
        if let Some(i) = gap.iter().position(|&b| b != 0) {
            return Err(FormatError::Padding { offset: (gap_from + i) as u64, value: gap[i] });
        }
        (*part, gap_from) = (found, to);
    }
    if gap_from != bytes.len() {
        return Err(FormatError::TrailingBytes { end: gap_from as u64 });
    }
    for ((part, section), &name) in parts.iter().zip(sections).zip(names) {
        let (stored, computed) = (section.checksum, crc32fast::hash(part));
        if stored != computed {
            return Err(FormatError::SectionChecksum { section: name.into(), stored, computed });
        }
    }
    Ok(parts)
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
        .map_err(|source| Error::Format { path: path.to_owned(), source: Box::new(source) })?;
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

/// Returns the CRC-32 of successive pieces of bytes.
pub fn checksum(chunks: impl Iterator<Item = Vec<u8>>) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    chunks.for_each(|c| hasher.update(&c));
    hasher.finalize()
}

/// Returns the zeros from `at` to a section's `offset`, fewer than 16.
pub fn gap(at: u64, offset: u64) -> &'static [u8] {
    &[0; ALIGNMENT as usize][..(offset - at) as usize]
}

/// Writes a section that begins at `offset`. Returns the offset at which it ends.
///
/// # Errors
/// Returns the errors of `out`.
pub fn put(out: &mut impl Write, offset: u64, chunks: impl Iterator<Item = Vec<u8>>) -> io::Result<u64> {
    let mut end = offset;
    for chunk in chunks {
        out.write_all(&chunk)?;
        end += chunk.len() as u64;
    }
    Ok(end)
}
