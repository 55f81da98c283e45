//! [`ShadowFile`] -> bytes, and onto a disk so that a reader sees the old file or the new one, never half of either.

use std::io::{self, ErrorKind, Write};
use std::path::Path;

use super::fields::field;
use super::header::Header;
use super::sections::{checksum, gap, lay_out, put};
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
        lay_out(HEADER_BYTES, self.body.section_lengths())[2].end()
    }

    /// The header of a valid file.
    pub(super) fn header(&self) -> Result<Header, FormatError> {
        let (size, root_level, top_dims) = self.body.space();
        if size != self.grid.size {
            return Err(field("size", format!("{size:?}"), format!("the grid's {:?}", self.grid.size)));
        }
        self.body.validate()?;
        let mut header = Header {
            grid: self.grid,
            settings: self.settings,
            root_level,
            top_dims,
            layout: self.body.layout(),
            sections: lay_out(HEADER_BYTES, self.body.section_lengths()),
        };
        header.check()?;
        for (i, section) in header.sections.iter_mut().enumerate() {
            section.checksum = checksum(self.body.chunks(i));
        }
        Ok(header)
    }

    fn encode(&self, header: &Header, out: &mut impl Write) -> io::Result<u64> {
        out.write_all(&header.encode())?;
        let mut at = HEADER_BYTES as u64;
        for (i, section) in header.sections.iter().enumerate() {
            out.write_all(gap(at, section.offset))?;
            at = put(out, section.offset, self.body.chunks(i))?;
        }
        out.flush()?;
        Ok(at)
    }
}
