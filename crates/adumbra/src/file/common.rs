//! A grid's common section, as stored and as used, and the shapes that coded bundles need from it.

use std::fmt;

use crate::coder;
use crate::error::FormatError;
use crate::file::sections::u32_words;
use crate::layout::depths::ShapePlace;
use crate::layout::depths::page::{BUNDLE_PAGES, Page};
use crate::settings::Encoding;

/// Whether a coded part of `stored_bytes` may have shapes of `shapes_bytes` raw bytes.
pub(super) fn is_plausible(stored_bytes: u64, shapes_bytes: u64) -> bool {
    shapes_bytes.is_multiple_of(4) && shapes_bytes <= stored_bytes.saturating_mul(coder::LARGEST_RATIO)
}

/// A common section. Bundles of the same grid are read and written with it.
#[derive(Debug)]
pub struct CommonSection {
    words: Vec<u32>,
    /// The shapes, if the file is coded.
    shapes: Option<coder::Common>,
}

impl CommonSection {
    /// Takes the words of a common section to be written. `shapes` returns all of its shapes, by address.
    ///
    /// # Errors
    /// Returns [`FormatError::Uncodable`] if the section is to be coded and is not laid out as bakes do.
    pub fn new(
        words: Vec<u32>,
        shapes: impl FnOnce() -> Vec<ShapePlace>,
        encoding: Encoding,
    ) -> Result<Self, FormatError> {
        let shapes = match encoding {
            Encoding::Raw => None,
            Encoding::Coded => Some(coder::Common::new(&words, &shapes()).map_err(|_| uncodable(NAME))?),
        };
        Ok(Self { words, shapes })
    }

    /// Reads the stored bytes of a common section. `section` names it.
    ///
    /// # Errors
    /// Returns the fault: bytes that are not whole words, or that cannot be decoded.
    pub fn parse(
        bytes: &[u8],
        raw_bytes: u64,
        encoding: Encoding,
        section: impl Fn() -> String,
    ) -> Result<Self, FormatError> {
        match encoding {
            Encoding::Raw if !bytes.len().is_multiple_of(4) => {
                Err(fault(section, format!("{} bytes", bytes.len()), "whole words"))
            }
            Encoding::Raw => Ok(Self { words: u32_words(bytes), shapes: None }),
            Encoding::Coded if bytes.is_empty() => {
                Ok(Self { words: Vec::new(), shapes: Some(coder::Common::default()) })
            }
            Encoding::Coded => {
                let (shapes, words) = coder::decode_common(bytes, raw_bytes as usize / 4)
                    .map_err(|_| FormatError::Coded { section: section() })?;
                Ok(Self { words, shapes: Some(shapes) })
            }
        }
    }

    /// Returns the words.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Returns how the bundles of the same grid are stored.
    pub fn encoding(&self) -> Encoding {
        if self.shapes.is_some() { Encoding::Coded } else { Encoding::Raw }
    }

    /// Returns the stored bytes.
    ///
    /// # Errors
    /// Returns [`FormatError::Uncodable`] if the section is not laid out as bakes do.
    pub(super) fn to_bytes(&self) -> Result<Vec<u8>, FormatError> {
        match &self.shapes {
            _ if self.words.is_empty() => Ok(Vec::new()),
            None => Ok(self.words.iter().flat_map(|word| word.to_le_bytes()).collect()),
            Some(shapes) => coder::encode_common(shapes, self.words.len()).map_err(|_| uncodable(NAME)),
        }
    }

    /// Returns the stored bytes of a bundle. `name` names the bundle.
    ///
    /// # Errors
    /// Returns [`FormatError::Uncodable`] if the pages are to be coded and are not laid out as bakes do.
    pub(super) fn bundle_to_bytes(
        &self,
        pages: &[Page<'_>; BUNDLE_PAGES],
        name: impl fmt::Display,
    ) -> Result<Vec<u8>, FormatError> {
        match &self.shapes {
            None => {
                let heads = pages.iter().flat_map(|page| [page.root, page.base, page.words.len() as u32]);
                let mut bytes: Vec<u8> = heads.flat_map(u32::to_le_bytes).collect();
                bytes.reserve(pages.iter().map(|page| 4 * page.words.len()).sum());
                for page in pages {
                    page.words.iter().for_each(|word| bytes.extend(word.to_le_bytes()));
                }
                Ok(bytes)
            }
            Some(shapes) => coder::encode_bundle(pages, shapes).map_err(|_| uncodable(name)),
        }
    }

    /// Returns the words of a bundle from its stored bytes: the heads of its pages, and the pages. `section`
    /// names it.
    ///
    /// # Errors
    /// Returns [`FormatError::Coded`] if the bytes cannot be decoded.
    pub fn parse_bundle(
        &self,
        bytes: &[u8],
        raw_bytes: u32,
        section: impl Fn() -> String,
    ) -> Result<Vec<u32>, FormatError> {
        match &self.shapes {
            None => Ok(u32_words(bytes)),
            Some(shapes) => coder::decode_bundle(bytes, raw_bytes as usize / 4, shapes)
                .map_err(|_| FormatError::Coded { section: section() }),
        }
    }
}

/// Name of the section in messages of a writer.
const NAME: &str = "common section";

/// Returns the error for a bundle, or another part, that differs from its description.
pub(super) fn fault(
    section: impl Fn() -> String,
    found: impl Into<String>,
    expected: &'static str,
) -> FormatError {
    FormatError::Bundle { section: section(), found: found.into(), expected }
}

fn uncodable(section: impl fmt::Display) -> FormatError {
    FormatError::Uncodable { section: section.to_string() }
}
