//! Bytes -> [`TreeFile`]. Nothing is allocated before the file's length has been found to justify it.

use std::path::Path;

use super::body::{TreeBody, WORDS};
use super::header::{BODY, Header, REGION_BYTES, SECTIONS};
use super::{TREE_HEADER_BYTES, TreeFile};
use crate::error::{Error, Result};
use crate::format::FormatError;
use crate::format::fields::{Decoder, field};
use crate::format::sections::{bounds, read_file, split};
use crate::tree::{Region, Regions, leaf_voxels};

impl TreeFile {
    /// Reads and checks the file at `path`.
    ///
    /// The header is read first, so a large file of another kind is refused without being read.
    ///
    /// # Errors
    /// [`Error::Io`] where the system refuses, [`Error::Format`] where the file is not valid.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let bytes = read_file(path, TREE_HEADER_BYTES, |front| Ok(Header::parse(front)?.file_bytes()))?;
        Self::parse(&bytes).map_err(|source| Error::Format { path: path.to_owned(), source })
    }

    /// Decodes and checks a whole file.
    ///
    /// Cost: time linear in `bytes`; memory for the decoded parts, and at most a byte and a half a word while they
    /// are checked.
    ///
    /// # Errors
    /// What is wrong, with the values; any bytes that are not exactly one valid file are refused.
    pub fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let header = Header::parse(bytes)?;
        let [regions, body, attribute] = split(bytes, TREE_HEADER_BYTES, &SECTIONS, &header.sections)?;
        let regions = Regions { base_depth: header.base_depth, list: read_regions(regions)? };
        check_regions(&regions, header.space.depth)?;
        let body = TreeBody::read(header.body_code, header.space.depth, body)?;
        check_attribute(&body, attribute)?;
        Ok(Self {
            space: header.space,
            sun: header.sun,
            settings: header.settings,
            regions,
            body,
            attribute: attribute.to_vec(),
            attribute_kind: header.attribute_kind,
        })
    }

    /// The file that [`TreeFile::without_words`] took apart: `rest` with `words` as its body. The words may have
    /// travelled apart, as a texture; the checksums tell whether they are the right ones.
    ///
    /// # Errors
    /// As [`TreeFile::parse`]; words that are more or fewer than the header says; a file whose body is no words.
    pub fn with_words(rest: &[u8], words: &[u32]) -> Result<Self, FormatError> {
        let header = Header::parse(rest)?;
        if header.body_code != WORDS {
            return Err(field("body_kind", header.body_code.to_string(), "1, as its words stand apart"));
        }
        let body = header.sections[BODY];
        let length = words.len() as u64 * 4;
        if length != body.length {
            return Err(bounds(
                "body",
                "length",
                body.length,
                format!("{length}, the bytes of the words given"),
            ));
        }
        let (needed, have) = (body.offset, rest.len() as u64);
        // An offset within `rest` fits `usize`.
        let Some((before, after)) = rest.split_at_checked(body.offset as usize).filter(|_| needed <= have)
        else {
            return Err(FormatError::Truncated { what: SECTIONS[BODY], needed, have });
        };
        let mut whole = Vec::with_capacity(rest.len() + words.len() * 4);
        whole.extend_from_slice(before);
        whole.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        whole.extend_from_slice(after);
        Self::parse(&whole)
    }
}

/// Whether every region is one, and the space as deep as the deepest part.
pub(super) fn check_regions(regions: &Regions, depth: u32) -> Result<(), FormatError> {
    for (index, &region) in regions.list.iter().enumerate() {
        // One at a time, so that the message can say which.
        let alone = Regions { base_depth: regions.base_depth, list: vec![region] };
        alone.check().map_err(|error| {
            let (value, expected) = match error {
                Error::OptionRange { value, range, .. } => (value, range),
                other => (other.to_string(), "no fault"),
            };
            FormatError::Region { index, value, expected: expected.to_owned() }
        })?;
    }
    let deepest = regions.depth();
    if depth != deepest {
        let expected = format!("{deepest}, as the deepest of base_depth and regions");
        return Err(field("depth", depth.to_string(), expected));
    }
    Ok(())
}

/// Whether an attribute has a byte for each leaf voxel.
pub(super) fn check_attribute(body: &TreeBody, attribute: &[u8]) -> Result<(), FormatError> {
    if let (TreeBody::Words(tree), false) = (body, attribute.is_empty()) {
        let (length, needed) = (attribute.len() as u64, leaf_voxels(tree));
        if length != needed {
            let expected = format!("{needed}, one a voxel of the tree's leaves of eight");
            return Err(bounds("attribute", "length", length, expected));
        }
    }
    Ok(())
}

/// The records of a section whose length is a multiple of theirs.
fn read_regions(section: &[u8]) -> Result<Vec<Region>, FormatError> {
    let records = section.chunks_exact(REGION_BYTES as usize);
    let read = |(index, bytes)| {
        let mut fields = Decoder { bytes };
        let region = Region { x: fields.f64s()?, z: fields.f64s()?, depth: fields.u32()? };
        match fields.u32()? {
            0 => Ok(region),
            word => {
                let value = format!("{word:#x} in its reserved word");
                Err(FormatError::Region { index, value, expected: "0".to_owned() })
            }
        }
    };
    records.enumerate().map(read).collect()
}
