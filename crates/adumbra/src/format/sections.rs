//! Sections behind a header: where they lie, the zeros between them, their checksums, and reading and writing a file
//! of them.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use super::FormatError;
use crate::error::{Error, Result};

/// Sections begin at multiples of this.
const ALIGNMENT: u64 = 16;
/// Bytes encoded at a time.
const CHUNK_BYTES: usize = 1 << 16;

/// One row of the section table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Section {
    pub(super) offset: u64,
    pub(super) length: u64,
    pub(super) checksum: u32,
}

impl Section {
    pub(super) fn end(&self) -> u64 {
        self.offset.saturating_add(self.length)
    }
}

/// Where the sections of these lengths lie behind a header; checksums are left at 0.
pub(super) fn lay_out<const N: usize>(header_bytes: usize, lengths: [u64; N]) -> [Section; N] {
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

/// Checks that sections lie where [`lay_out`] puts them, and their lengths: `expected` says for a section and its
/// length what the length should be where it is not.
pub(super) fn check_sections<const N: usize>(
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

pub(super) fn bounds(
    section: &'static str,
    field: &'static str,
    value: u64,
    expected: impl Into<String>,
) -> FormatError {
    FormatError::SectionBounds { section, field, value, expected: expected.into() }
}

/// The sections' bytes, with padding, lengths and checksums checked. The header has proved their order.
pub(super) fn split<'a, const N: usize>(
    bytes: &'a [u8],
    header_bytes: usize,
    names: &[&'static str; N],
    sections: &[Section; N],
) -> Result<[&'a [u8]; N], FormatError> {
    let have = bytes.len() as u64;
    let mut parts = [&[][..]; N];
    let mut gap_from = header_bytes;
    for ((part, section), &what) in parts.iter_mut().zip(sections).zip(names) {
        // A section that lies within `bytes` has offsets that fit `usize`.
        let (from, to) = (section.offset as usize, section.end() as usize);
        let (true, Some(gap), Some(found)) =
            (section.end() <= have, bytes.get(gap_from..from), bytes.get(from..to))
        else {
            return Err(FormatError::Truncated { what, needed: section.end(), have });
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
            return Err(FormatError::SectionChecksum { section: name, stored, computed });
        }
    }
    Ok(parts)
}

/// Reads the file at `path`. `file_bytes` is given as many as `header_bytes` first bytes and says how long the file
/// is, so a large file of another kind is refused without being read.
pub(super) fn read_file(
    path: &Path,
    header_bytes: usize,
    file_bytes: impl FnOnce(&[u8]) -> Result<u64, FormatError>,
) -> Result<Vec<u8>> {
    let mut file = File::open(path).map_err(Error::io("read", path))?;
    let mut bytes = Vec::new();
    (&mut file).take(header_bytes as u64).read_to_end(&mut bytes).map_err(Error::io("read", path))?;
    let whole = file_bytes(&bytes).map_err(|source| Error::Format { path: path.to_owned(), source })?;
    // One byte more than there should be, to see whether the file goes on.
    let rest = whole.saturating_sub(bytes.len() as u64).saturating_add(1);
    file.take(rest).read_to_end(&mut bytes).map_err(Error::io("read", path))?;
    Ok(bytes)
}

/// Little-endian words of a section of whole words.
pub(super) fn u32_words(bytes: &[u8]) -> Vec<u32> {
    bytes.as_chunks().0.iter().map(|&b| u32::from_le_bytes(b)).collect()
}

pub(super) fn u32_chunks(words: &[u32]) -> impl Iterator<Item = Vec<u8>> {
    words.chunks(CHUNK_BYTES / 4).map(|c| c.iter().flat_map(|w| w.to_le_bytes()).collect())
}

pub(super) fn u16_chunks(units: &[u16]) -> impl Iterator<Item = Vec<u8>> {
    units.chunks(CHUNK_BYTES / 2).map(|c| c.iter().flat_map(|u| u.to_le_bytes()).collect())
}

pub(super) fn u64_chunks(words: &[u64]) -> impl Iterator<Item = Vec<u8>> {
    words.chunks(CHUNK_BYTES / 8).map(|c| c.iter().flat_map(|w| w.to_le_bytes()).collect())
}

pub(super) fn checksum(chunks: impl Iterator<Item = Vec<u8>>) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    chunks.for_each(|c| hasher.update(&c));
    hasher.finalize()
}

/// The zeros from `at` to a section's `offset`, fewer than 16.
pub(super) fn gap(at: u64, offset: u64) -> &'static [u8] {
    &[0; ALIGNMENT as usize][..(offset - at) as usize]
}

/// Writes a section that begins at `offset`; returns where it ends.
pub(super) fn put(
    out: &mut impl Write,
    offset: u64,
    chunks: impl Iterator<Item = Vec<u8>>,
) -> io::Result<u64> {
    let mut end = offset;
    for chunk in chunks {
        out.write_all(&chunk)?;
        end += chunk.len() as u64;
    }
    Ok(end)
}
