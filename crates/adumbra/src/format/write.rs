//! [`ShadowFile`] -> bytes, and onto a disk so that a reader sees the old file or the new one, never half of either.

use std::io::{self, ErrorKind, Write};
use std::path::Path;

use super::fields::field;
use super::header::Header;
use super::sections::{checksum, gap, lay_out, put, u32_chunks, u64_chunks};
use super::{FormatError, HEADER_BYTES, ShadowFile};
use crate::error::{Error, Result};
use crate::files::replace_file;

impl ShadowFile {
    /// Writes the file at `path`; returns its bytes.
    ///
    /// The bytes go to a temporary file in the same folder, which takes the name `path` once it is complete and
    /// synced. On any failure the temporary file is removed and what was at `path` stays as it was.
    ///
    /// # Errors
    /// [`Error::Io`] where the system refuses (the message says what to do about a missing folder or a full disk),
    /// [`Error::Format`] where the contents are not valid.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<u64> {
        let path = path.as_ref();
        let header = self.header().map_err(|source| Error::Format { path: path.to_owned(), source })?;
        replace_file(path, |file| self.encode(&header, file))
    }

    /// Writes the bytes of the file to `out`, in pieces of some 64 KiB; returns how many.
    ///
    /// # Errors
    /// What `out` says; [`ErrorKind::InvalidData`] with a [`FormatError`] where the contents are not valid.
    pub fn write_to(&self, out: &mut impl Write) -> io::Result<u64> {
        let header = self.header().map_err(|e| io::Error::new(ErrorKind::InvalidData, e))?;
        self.encode(&header, out)
    }

    /// Bytes of the file.
    pub fn encoded_len(&self) -> u64 {
        lay_out(HEADER_BYTES, self.section_lengths())[2].end()
    }

    fn section_lengths(&self) -> [u64; 3] {
        let dag = &self.dag;
        [dag.top.len() as u64 * 4, dag.nodes.len() as u64 * 4, dag.slabs.len() as u64 * 8]
    }

    /// The header of a valid file.
    pub(super) fn header(&self) -> Result<Header, FormatError> {
        let dag = &self.dag;
        if dag.size != self.grid.size {
            return Err(field("size", format!("{:?}", dag.size), format!("the grid's {:?}", self.grid.size)));
        }
        dag.validate()?;
        let mut header = Header {
            grid: self.grid,
            settings: self.settings,
            root_level: dag.root_level,
            top_dims: dag.top_dims,
            sections: lay_out(HEADER_BYTES, self.section_lengths()),
        };
        header.check()?;
        let checksums = [
            checksum(u32_chunks(&dag.top)),
            checksum(u32_chunks(&dag.nodes)),
            checksum(u64_chunks(&dag.slabs)),
        ];
        for (section, checksum) in header.sections.iter_mut().zip(checksums) {
            section.checksum = checksum;
        }
        Ok(header)
    }

    fn encode(&self, header: &Header, out: &mut impl Write) -> io::Result<u64> {
        out.write_all(&header.encode())?;
        let mut at = HEADER_BYTES as u64;
        let dag = &self.dag;
        let [top, nodes, slabs] = &header.sections;
        out.write_all(gap(at, top.offset))?;
        at = put(out, top.offset, u32_chunks(&dag.top))?;
        out.write_all(gap(at, nodes.offset))?;
        at = put(out, nodes.offset, u32_chunks(&dag.nodes))?;
        out.write_all(gap(at, slabs.offset))?;
        at = put(out, slabs.offset, u64_chunks(&dag.slabs))?;
        out.flush()?;
        Ok(at)
    }
}
