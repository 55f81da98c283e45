//! Decodes bytes to a [`TreeFile`]. Nothing is allocated before the length of the file justifies it.

use std::io::Read as _;
use std::path::Path;

use adumbra::{FormatError, IoError};

use crate::sections::split;
use crate::tree::error::TreeFileError;
use crate::tree::error::{Error, Result};
use crate::tree::file::body::{TreeBody, WORDS};
use crate::tree::file::header::{BODY, Header, REGION_BYTES, SECTIONS};
use crate::tree::file::{TREE_HEADER_BYTES, TREE_MAGIC, TreeFile};
use crate::tree::leaf_voxels::leaf_voxels;
use crate::tree::space::{Region, Regions};
use adumbra::file::fields::{Decoder, field};
use adumbra::file::sections::{bounds, read_file};

impl TreeFile {
    /// Whether the file at `path` begins with the magic of tree files.
    ///
    /// # Errors
    /// Returns [`Error::Io`](crate::tree::Error::Io) if it cannot be read.
    pub fn is_one(path: impl AsRef<Path>) -> Result<bool> {
        let path = path.as_ref();
        let mut front = Vec::new();
        std::fs::File::open(path)
            .and_then(|file| file.take(TREE_MAGIC.len() as u64).read_to_end(&mut front))
            .map_err(IoError::at("read", path))?;
        Ok(front == TREE_MAGIC)
    }

    /// Reads and checks the file at `path`.
    ///
    /// The header is read first, so a large file of another kind is refused without being read.
    ///
    /// # Errors
    /// Returns [`Error::Io`] if the operating system refuses the read, and [`Error::Format`] if the file is
    /// not valid.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let bytes = read_file(path, TREE_HEADER_BYTES, |front| Ok(Header::parse(front)?.file_bytes()))?;
        Self::from_bytes(&bytes)
            .map_err(|source| Error::Format { path: path.to_owned(), source: Box::new(source) })
    }

    /// Decodes and checks a whole file.
    ///
    /// Cost: time linear in `bytes`; memory for the decoded parts, plus at most one and a half bytes per word
    /// during the check.
    ///
    /// # Errors
    /// Returns the fault found, with the values. Any bytes that are not exactly one valid file are refused.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, TreeFileError> {
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

    /// Rebuilds the file that [`TreeFile::without_words`] took apart: `rest` with `words` as its body. The
    /// words may have been stored separately, as a texture; the checksums show whether they are the right
    /// ones.
    ///
    /// # Errors
    /// Returns the errors of [`TreeFile::from_bytes`], and an error if the number of words differs from the
    /// header's or the body of the file is not words.
    pub fn with_words(rest: &[u8], words: &[u32]) -> Result<Self, TreeFileError> {
        let header = Header::parse(rest)?;
        if header.body_code != WORDS {
            return Err(field(
                "body_kind",
                header.body_code.to_string(),
                "1, because its words are stored separately",
            )
            .into());
        }
        let body = header.sections[BODY];
        let length = words.len() as u64 * 4;
        if length != body.length {
            return Err(bounds(
                "body",
                "length",
                body.length,
                format!("{length}, the size of the given words"),
            )
            .into());
        }
        let (needed, have) = (body.offset, rest.len() as u64);
        // An offset within `rest` fits `usize`.
        let Some((before, after)) = rest.split_at_checked(body.offset as usize).filter(|_| needed <= have)
        else {
            return Err(FormatError::Truncated { what: SECTIONS[BODY].into(), needed, have }.into());
        };
        let mut whole = Vec::with_capacity(rest.len() + words.len() * 4);
        whole.extend_from_slice(before);
        whole.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        whole.extend_from_slice(after);
        Self::from_bytes(&whole)
    }
}

/// Checks that every region is valid, and that the depth of the space is that of the deepest part.
pub(crate) fn check_regions(regions: &Regions, depth: u32) -> Result<(), TreeFileError> {
    for (index, &region) in regions.list.iter().enumerate() {
        // One at a time, so that the message can name the index.
        let alone = Regions { base_depth: regions.base_depth, list: vec![region] };
        alone.check().map_err(|error| TreeFileError::Region {
            index,
            value: error.value,
            expected: error.range.to_owned(),
        })?;
    }
    let deepest = regions.depth();
    if depth != deepest {
        let expected = format!("{deepest}, the largest depth of base_depth and the regions");
        return Err(field("depth", depth.to_string(), expected).into());
    }
    Ok(())
}

/// Checks that an attribute has one byte per leaf voxel.
pub(crate) fn check_attribute(body: &TreeBody, attribute: &[u8]) -> Result<(), TreeFileError> {
    if let (TreeBody::Words(tree), false) = (body, attribute.is_empty()) {
        let (length, needed) = (attribute.len() as u64, leaf_voxels(tree));
        if length != needed {
            let expected = format!("{needed}, one per voxel of the tree's leaves of eight");
            return Err(bounds("attribute", "length", length, expected).into());
        }
    }
    Ok(())
}

/// Reads the records of a section whose length is a multiple of the record size.
fn read_regions(section: &[u8]) -> Result<Vec<Region>, TreeFileError> {
    let records = section.chunks_exact(REGION_BYTES as usize);
    let read = |(index, bytes)| {
        let mut fields = Decoder { bytes };
        let region = Region { x: fields.f64s()?, z: fields.f64s()?, depth: fields.u32()? };
        match fields.u32()? {
            0 => Ok(region),
            word => {
                let value = format!("{word:#x} in its reserved word");
                Err(TreeFileError::Region { index, value, expected: "0".to_owned() })
            }
        }
    };
    records.enumerate().map(read).collect()
}
