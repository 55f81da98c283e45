//! The graph file: a graph with its grid and settings, as bytes.

use std::io::{self, ErrorKind, Read as _, Write};
use std::path::Path;

use adumbra::file::fields::field;
use adumbra::file::sections::read_file;
use adumbra::{FileSettings, IoError, LightGrid};

use crate::dag::body::DagBody;
use crate::dag::error::{Error, Result};
use crate::dag::file_error::DagFileError;
use crate::dag::header::{DAG_HEADER_BYTES, DAG_MAGIC, Header, SECTIONS};
use crate::sections::{checksum, gap, lay_out, put, split};

/// The contents of a graph file.
#[derive(Clone, Debug, PartialEq)]
pub struct DagFile {
    /// Placement of the voxels in the world.
    pub grid: LightGrid,
    /// Settings of the bake.
    pub settings: FileSettings,
    /// The voxels.
    pub body: DagBody,
}

impl DagFile {
    /// Whether the file at `path` begins with the magic of graph files.
    ///
    /// # Errors
    /// Returns [`Error::Io`] if it cannot be read.
    pub fn is_one(path: impl AsRef<Path>) -> Result<bool> {
        let path = path.as_ref();
        let mut front = Vec::new();
        std::fs::File::open(path)
            .and_then(|file| file.take(DAG_MAGIC.len() as u64).read_to_end(&mut front))
            .map_err(IoError::at("read", path))?;
        Ok(front == DAG_MAGIC)
    }

    /// Reads and validates the file at `path`, header first.
    ///
    /// # Errors
    /// Returns [`Error::Io`] if the operating system fails to read the file, and [`Error::Format`] if the
    /// file is not valid.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let bytes = read_file(path, DAG_HEADER_BYTES, |front| Ok(Header::parse(front)?.file_bytes()))?;
        Self::from_bytes(&bytes)
            .map_err(|source| Error::Format { path: path.to_owned(), source: Box::new(source) })
    }

    /// Decodes and validates a whole file.
    ///
    /// # Errors
    /// Returns the fault with the values found. All bytes that are not exactly one valid file are refused.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, DagFileError> {
        let header = Header::parse(bytes)?;
        let sections = split(bytes, DAG_HEADER_BYTES, &SECTIONS, &header.sections)?;
        let body = DagBody::parse(&header, sections);
        body.validate()?;
        Ok(Self { grid: header.grid, settings: header.settings, body })
    }

    /// Returns the size of the file in bytes.
    pub fn encoded_len(&self) -> u64 {
        self.body.encoded_len()
    }

    /// Returns the header of the file, with the checksums of its sections.
    ///
    /// # Errors
    /// Returns the fault in the contents, with the values found.
    pub fn header(&self) -> Result<Header, DagFileError> {
        let (size, root_level, top_dims) = self.body.space();
        if size != self.grid.size {
            return Err(field("size", format!("{size:?}"), format!("the grid's {:?}", self.grid.size)).into());
        }
        self.body.validate()?;
        let mut header = Header {
            grid: self.grid,
            settings: self.settings,
            root_level,
            top_dims,
            layout: self.body.layout(),
            sections: lay_out(DAG_HEADER_BYTES, self.body.section_lengths()),
        };
        header.check()?;
        for (i, section) in header.sections.iter_mut().enumerate() {
            section.checksum = checksum(self.body.chunks(i));
        }
        Ok(header)
    }

    /// Writes the bytes of the file to `out` and returns their number.
    ///
    /// # Errors
    /// Returns the errors of `out`, and [`ErrorKind::InvalidData`] with a [`DagFileError`] if the contents
    /// are not valid.
    pub fn write_to(&self, out: &mut impl Write) -> io::Result<u64> {
        let header = self.header().map_err(|e| io::Error::new(ErrorKind::InvalidData, e))?;
        out.write_all(&header.encode())?;
        let mut at = DAG_HEADER_BYTES as u64;
        for (i, section) in header.sections.iter().enumerate() {
            out.write_all(gap(at, section.offset))?;
            at = put(out, section.offset, self.body.chunks(i))?;
        }
        Ok(at)
    }
}
