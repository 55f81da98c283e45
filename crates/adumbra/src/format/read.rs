//! Bytes -> [`ShadowFile`]. Nothing is allocated before the file's length has been found to justify it.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::header::{Header, SECTIONS, Section};
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
        let refused = |source| Error::Format { path: path.to_owned(), source };
        let mut file = File::open(path).map_err(Error::io("read", path))?;
        let mut bytes = Vec::new();
        let header_bytes = HEADER_BYTES as u64;
        (&mut file).take(header_bytes).read_to_end(&mut bytes).map_err(Error::io("read", path))?;
        let file_bytes = Header::parse(&bytes).map_err(refused)?.file_bytes();
        // One byte more than there should be, to see whether the file goes on.
        let rest = (file_bytes - header_bytes).saturating_add(1);
        file.take(rest).read_to_end(&mut bytes).map_err(Error::io("read", path))?;
        Self::from_bytes(&bytes).map_err(refused)
    }

    /// Decodes and checks a whole file.
    ///
    /// Cost: time linear in `bytes`; memory for the decoded words and a byte a node word.
    ///
    /// # Errors
    /// What is wrong, with the values; any bytes that are not exactly one valid file are refused.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let header = Header::parse(bytes)?;
        let [top, nodes, slabs] = split(bytes, &header.sections)?;
        let dag = Dag {
            size: header.grid.size,
            root_level: header.root_level,
            top_dims: header.top_dims,
            top: words(top),
            nodes: words(nodes),
            slabs: slabs.as_chunks().0.iter().map(|&b| u64::from_le_bytes(b)).collect(),
        };
        dag.validate()?;
        Ok(Self { grid: header.grid, settings: header.settings, dag })
    }
}

/// The sections' bytes, with padding, lengths and checksums checked. The header has proved their order.
fn split<'a>(bytes: &'a [u8], sections: &[Section; 3]) -> Result<[&'a [u8]; 3], FormatError> {
    let have = bytes.len() as u64;
    let mut parts = [&[][..]; 3];
    let mut gap_from = HEADER_BYTES;
    for ((part, section), &what) in parts.iter_mut().zip(sections).zip(&SECTIONS) {
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
    for ((part, section), &name) in parts.iter().zip(sections).zip(&SECTIONS) {
        let (stored, computed) = (section.checksum, crc32fast::hash(part));
        if stored != computed {
            return Err(FormatError::SectionChecksum { section: name, stored, computed });
        }
    }
    Ok(parts)
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.as_chunks().0.iter().map(|&b| u32::from_le_bytes(b)).collect()
}
