//! Encoding of a [`ShadowFile`].

use std::io::{self, ErrorKind, Write};

use crate::error::FormatError;
use crate::file::fields::field;
use crate::file::header::Header;
use crate::file::sections::{checksum, gap, lay_out, put};
use crate::file::{HEADER_BYTES, ShadowFile};

impl ShadowFile {
    /// Writes the bytes of the file to `out`, in pieces of some 64 KiB. Returns their number.
    ///
    /// # Errors
    /// Returns the errors of `out`, and [`ErrorKind::InvalidData`] with a [`FormatError`] if the contents are not
    /// valid.
    pub fn write_to(&self, out: &mut impl Write) -> io::Result<u64> {
        let header = self.header().map_err(|e| io::Error::new(ErrorKind::InvalidData, e))?;
        self.encode(&header, out)
    }

    /// Returns the size of the file in bytes.
    pub fn encoded_len(&self) -> u64 {
        self.body.encoded_len()
    }

    /// Returns the header of the file, with the checksums of its sections. Cost: one pass over the voxels.
    ///
    /// # Errors
    /// Returns the fault in the contents, with the values found.
    pub fn header(&self) -> Result<Header, FormatError> {
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
