//! The sections after a header, in both kinds of file of this crate: their offsets, padding and checksums.

use std::io::{self, Write};

use adumbra::FormatError;
use adumbra::file::sections::{Section, bounds};

/// Sections begin at multiples of this many bytes.
const ALIGNMENT: u64 = 16;
/// Number of bytes encoded at a time.
pub(crate) const CHUNK_BYTES: usize = 1 << 16;

/// A fault of the sections.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SectionFault {
    /// A fault that shadow files may have as well.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A padding byte between two sections is not zero.
    #[error(
        "the padding byte {offset} between two sections is {value:#04x}, but must be 0; copy the file again, or bake it again"
    )]
    Padding {
        /// The byte's offset in the file.
        offset: u64,
        /// The byte's value.
        value: u8,
    },
}

impl SectionFault {
    /// Returns the variant's name, which the test vectors use.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Format(error) => error.kind(),
            Self::Padding { .. } => "Padding",
        }
    }
}

/// Places sections of these lengths after a header. Their checksums are set to 0.
pub(crate) fn lay_out<const N: usize>(header_bytes: usize, lengths: [u64; N]) -> [Section; N] {
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
pub(crate) fn check_sections<const N: usize>(
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

/// Returns the bytes of each section, after checking padding, lengths and checksums. The order of the
/// sections must have been checked with the header.
///
/// # Errors
/// Returns the fault with the values found.
pub(crate) fn split<'a, const N: usize>(
    bytes: &'a [u8],
    header_bytes: usize,
    names: &[&'static str; N],
    sections: &[Section; N],
) -> Result<[&'a [u8]; N], SectionFault> {
    let have = bytes.len() as u64;
    let mut parts = [&[][..]; N];
    let mut gap_from = header_bytes;
    for ((part, section), &what) in parts.iter_mut().zip(sections).zip(names) {
        // A section within `bytes` has offsets that fit `usize`.
        let (from, to) = (section.offset as usize, section.end() as usize);
        let (true, Some(gap), Some(found)) =
            (section.end() <= have, bytes.get(gap_from..from), bytes.get(from..to))
        else {
            return Err(FormatError::Truncated { what: what.into(), needed: section.end(), have }.into());
        };
        if let Some(i) = gap.iter().position(|&b| b != 0) {
            return Err(SectionFault::Padding { offset: (gap_from + i) as u64, value: gap[i] });
        }
        (*part, gap_from) = (found, to);
    }
    if gap_from != bytes.len() {
        return Err(FormatError::TrailingBytes { end: gap_from as u64 }.into());
    }
    for ((part, section), &name) in parts.iter().zip(sections).zip(names) {
        let (stored, computed) = (section.checksum, crc32fast::hash(part));
        if stored != computed {
            return Err(FormatError::SectionChecksum { section: name.into(), stored, computed }.into());
        }
    }
    Ok(parts)
}

/// Encodes `words` in little-endian, in pieces of 64 KiB.
pub(crate) fn u32_chunks(words: &[u32]) -> impl Iterator<Item = Vec<u8>> {
    words.chunks(CHUNK_BYTES / 4).map(|c| c.iter().flat_map(|w| w.to_le_bytes()).collect())
}

/// Returns the CRC-32 of successive pieces of bytes.
pub(crate) fn checksum(chunks: impl Iterator<Item = Vec<u8>>) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    chunks.for_each(|c| hasher.update(&c));
    hasher.finalize()
}

/// Returns the zeros from `at` to a section's `offset`, fewer than 16.
pub(crate) fn gap(at: u64, offset: u64) -> &'static [u8] {
    &[0; ALIGNMENT as usize][..(offset - at) as usize]
}

/// Writes a section that begins at `offset`. Returns the offset at which it ends.
///
/// # Errors
/// Returns the errors of `out`.
pub(crate) fn put(
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
