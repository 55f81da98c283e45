//! Encodes a [`TreeFile`] to bytes.

use std::convert::Infallible;
use std::io::{self, ErrorKind, Write};

use crate::sections::{gap, lay_out, u32_chunks};
use crate::tree::error::TreeFileError;
use crate::tree::file::body::TreeBody;
use crate::tree::file::header::{ATTRIBUTE, BODY, Header, REGION_BYTES, REGIONS};
use crate::tree::file::read::{check_attribute, check_regions};
use crate::tree::file::{TREE_HEADER_BYTES, TreeFile};
use crate::tree::graph;
use crate::tree::space::Region;
use adumbra::file::fields::field;

impl TreeFile {
    /// Writes the file to `out` in pieces and returns the number of bytes.
    ///
    /// # Errors
    /// Returns the errors of `out`, and [`ErrorKind::InvalidData`] with a [`TreeFileError`] if the contents
    /// are not valid.
    pub fn write_to(&self, out: &mut impl Write) -> io::Result<u64> {
        self.check().map_err(|e| io::Error::new(ErrorKind::InvalidData, e))?;
        self.emit(None, &mut |bytes| out.write_all(bytes))?;
        out.flush()?;
        Ok(self.encoded_len())
    }

    /// Encodes the file. The contents are not checked: if [`TreeFile::check`] would refuse them,
    /// [`TreeFile::from_bytes`] refuses these bytes.
    pub fn encode(&self) -> Vec<u8> {
        self.collect(None)
    }

    /// Encodes the file without the bytes of the body, for words that are stored separately, as a texture.
    /// [`TreeFile::with_words`] puts the two together again. `None` if the body is not words.
    pub fn without_words(&self) -> Option<Vec<u8>> {
        matches!(self.body, TreeBody::Words(_)).then(|| self.collect(Some(BODY)))
    }

    /// Size of the file in bytes.
    pub fn encoded_len(&self) -> u64 {
        lay_out(TREE_HEADER_BYTES, self.section_lengths())[ATTRIBUTE].end()
    }

    /// Checks that the contents are those of a file that a reader accepts.
    ///
    /// # Errors
    /// Returns the fault found, with the values.
    pub fn check(&self) -> Result<(), TreeFileError> {
        let (depth, body) = (self.space.depth, self.body.depth());
        if depth != body {
            return Err(field("depth", depth.to_string(), format!("the body's {body}")).into());
        }
        self.header().check()?;
        check_regions(&self.regions, depth)?;
        if let TreeBody::Words(tree) = &self.body {
            graph::check(tree.depth(), tree.words())?;
        }
        check_attribute(&self.body, &self.attribute)
    }

    fn section_lengths(&self) -> [u64; 3] {
        let regions = self.regions.list.len() as u64 * REGION_BYTES;
        [regions, self.body.bytes_len(), self.attribute.len() as u64]
    }

    /// The header, without the checksums of the sections.
    fn header(&self) -> Header {
        Header {
            space: self.space,
            base_depth: self.regions.base_depth,
            region_count: u32::try_from(self.regions.list.len()).unwrap_or(u32::MAX),
            body_code: self.body.code(),
            attribute_kind: self.attribute_kind,
            sun: self.sun,
            settings: self.settings,
            sections: lay_out(TREE_HEADER_BYTES, self.section_lengths()),
        }
    }

    fn collect(&self, skipped: Option<usize>) -> Vec<u8> {
        let mut all = Vec::with_capacity(usize::try_from(self.encoded_len()).unwrap_or(0));
        let Ok(()) = self.emit(skipped, &mut |bytes| {
            all.extend_from_slice(bytes);
            Ok::<(), Infallible>(())
        });
        all
    }

    /// Passes the bytes of the file to `put` piece by piece, without those of the `skipped` section, if any.
    fn emit<E>(&self, skipped: Option<usize>, put: &mut impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        let mut header = self.header();
        for (i, section) in header.sections.iter_mut().enumerate() {
            let mut hasher = crc32fast::Hasher::new();
            let Ok(()) = self.section(i, &mut |bytes| {
                hasher.update(bytes);
                Ok::<(), Infallible>(())
            });
            section.checksum = hasher.finalize();
        }
        put(&header.encode())?;
        let mut at = TREE_HEADER_BYTES as u64;
        for (i, section) in header.sections.iter().enumerate() {
            put(gap(at, section.offset))?;
            if skipped != Some(i) {
                self.section(i, put)?;
            }
            at = section.end();
        }
        Ok(())
    }

    /// Passes the bytes of a section to `put`.
    fn section<E>(&self, section: usize, put: &mut impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        match (section, &self.body) {
            (REGIONS, _) => self.regions.list.iter().try_for_each(|region| put(&record(region))),
            (BODY, TreeBody::Words(tree)) => u32_chunks(tree.words()).try_for_each(|chunk| put(&chunk)),
            (BODY, TreeBody::Symmetric(tree)) => put(tree.bytes()),
            _ => put(&self.attribute),
        }
    }
}

/// Encodes a region as a record of the file.
fn record(region: &Region) -> Vec<u8> {
    let [x, z] = [region.x, region.z];
    let mut bytes: Vec<u8> = [x, z].as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    bytes.extend(region.depth.to_le_bytes());
    bytes.extend([0; 4]);
    bytes
}
