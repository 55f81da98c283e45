//! [`TreeFile`] -> bytes, and onto a disk so that a reader sees the old file or the new one, never half of either.

use std::convert::Infallible;
use std::io::{self, Write};
use std::path::Path;

use super::body::TreeBody;
use super::header::{ATTRIBUTE, BODY, Header, REGION_BYTES, REGIONS};
use super::read::{check_attribute, check_regions};
use super::{TREE_HEADER_BYTES, TreeFile};
use crate::error::{Error, Result};
use crate::files::replace_file;
use crate::format::FormatError;
use crate::format::fields::field;
use crate::format::sections::{gap, lay_out, u32_chunks};
use crate::tree::{Region, check_words};

impl TreeFile {
    /// Writes the file at `path`; returns its bytes. It is there whole or not at all, as with
    /// [`ShadowFile::write`](crate::format::ShadowFile::write).
    ///
    /// # Errors
    /// [`Error::Io`] where the system refuses (the message says what to do about a missing folder or a full disk),
    /// [`Error::Format`] where the contents are not valid.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<u64> {
        let path = path.as_ref();
        self.check().map_err(|source| Error::Format { path: path.to_owned(), source })?;
        replace_file(path, |file| self.write_unchecked(file))
    }

    /// The bytes of the file. The contents are not checked: of what [`TreeFile::check`] refuses, this makes bytes that
    /// [`TreeFile::parse`] refuses.
    pub fn encode(&self) -> Vec<u8> {
        self.collect(None)
    }

    /// The encoded file with the body's bytes cut out, for words that travel apart, as a texture;
    /// [`TreeFile::with_words`] puts them together again. `None` where the body is no words.
    pub fn without_words(&self) -> Option<Vec<u8>> {
        matches!(self.body, TreeBody::Words(_)).then(|| self.collect(Some(BODY)))
    }

    /// Bytes of the file.
    pub fn encoded_len(&self) -> u64 {
        lay_out(TREE_HEADER_BYTES, self.section_lengths())[ATTRIBUTE].end()
    }

    /// Whether the contents are those of a file that a reader takes.
    ///
    /// # Errors
    /// What is wrong, with the values.
    pub fn check(&self) -> Result<(), FormatError> {
        let (depth, body) = (self.space.depth, self.body.depth());
        if depth != body {
            return Err(field("depth", depth.to_string(), format!("the body's {body}")));
        }
        self.header().check()?;
        check_regions(&self.regions, depth)?;
        if let TreeBody::Words(tree) = &self.body {
            check_words(tree.depth(), tree.words())?;
        }
        check_attribute(&self.body, &self.attribute)
    }

    fn section_lengths(&self) -> [u64; 3] {
        let regions = self.regions.list.len() as u64 * REGION_BYTES;
        [regions, self.body.bytes_len(), self.attribute.len() as u64]
    }

    /// The header, but for the sections' checksums.
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

    fn write_unchecked(&self, out: &mut impl Write) -> io::Result<u64> {
        self.emit(None, &mut |bytes| out.write_all(bytes))?;
        out.flush()?;
        Ok(self.encoded_len())
    }

    fn collect(&self, left_out: Option<usize>) -> Vec<u8> {
        let mut all = Vec::with_capacity(usize::try_from(self.encoded_len()).unwrap_or(0));
        let Ok(()) = self.emit(left_out, &mut |bytes| {
            all.extend_from_slice(bytes);
            Ok::<(), Infallible>(())
        });
        all
    }

    /// Gives the bytes of the file one piece after the other, without those of one section where asked.
    fn emit<E>(
        &self,
        left_out: Option<usize>,
        put: &mut impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
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
            if left_out != Some(i) {
                self.section(i, put)?;
            }
            at = section.end();
        }
        Ok(())
    }

    /// Gives the bytes of a section.
    fn section<E>(&self, section: usize, put: &mut impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        match (section, &self.body) {
            (REGIONS, _) => self.regions.list.iter().try_for_each(|region| put(&record(region))),
            (BODY, TreeBody::Words(tree)) => u32_chunks(tree.words()).try_for_each(|chunk| put(&chunk)),
            (BODY, TreeBody::Symmetric(tree)) => put(tree.bytes()),
            _ => put(&self.attribute),
        }
    }
}

/// A region as the file has it.
fn record(region: &Region) -> Vec<u8> {
    let [x, z] = [region.x, region.z];
    let mut bytes: Vec<u8> = [x, z].as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    bytes.extend(region.depth.to_le_bytes());
    bytes.extend([0; 4]);
    bytes
}
