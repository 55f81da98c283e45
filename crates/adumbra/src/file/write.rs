//! Encoding of a [`ShadowFile`].

use std::io::{self, ErrorKind, Write};

use crate::error::FormatError;
use crate::file::fields::field;
use crate::file::header::Header;
use crate::file::sections::{checksum, gap, lay_out, put};
use crate::file::{HEADER_BYTES, ShadowFile, body};

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
        body::encoded_len(&self.tree)
    }

    /// Returns the header of the file, with the checksums of its sections. Cost: one pass over the voxels.
    ///
    /// # Errors
    /// Returns the fault in the contents, with the values found.
    pub fn header(&self) -> Result<Header, FormatError> {
        let tree = &*self.tree;
        if tree.size != self.grid.size {
            return Err(field(
                "size",
                format!("{:?}", tree.size),
                format!("the grid's {:?}", self.grid.size),
            ));
        }
        tree.validate()?;
        let mut header = Header {
            grid: self.grid,
            settings: self.settings,
            root_level: tree.root_level,
            top_dims: body::top_dims(tree),
            sections: lay_out(HEADER_BYTES, body::section_lengths(tree)),
        };
        header.check()?;
        for (i, section) in header.sections.iter_mut().enumerate() {
            section.checksum = checksum(body::chunks(tree, i));
        }
        Ok(header)
    }

    fn encode(&self, header: &Header, out: &mut impl Write) -> io::Result<u64> {
        out.write_all(&header.encode())?;
        let mut at = HEADER_BYTES as u64;
        for (i, section) in header.sections.iter().enumerate() {
            out.write_all(gap(at, section.offset))?;
            at = put(out, section.offset, body::chunks(&self.tree, i))?;
        }
        out.flush()?;
        Ok(at)
    }
}
