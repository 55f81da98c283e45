//! Decoding and validating of common sections and bundles.

use std::sync::{Arc, Mutex};

use crate::error::FormatError;
use crate::file::{Bundle, BundleEntry, CommonSection, GridEntry, name_of_bundle};
use crate::layout::depths::PageValidator;
use crate::layout::depths::page::{Page, page_dims, pages_of};
use crate::layout::depths::top::{block_level, page_blocks};
use crate::settings::Encoding;
use crate::stream::retry::StreamError;

/// A bundle in the bytes of a request.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored {
    pub(super) index: u32,
    /// By its place along x and y.
    pub(super) place: [u32; 2],
    pub(super) entry: BundleEntry,
    /// Offset in the request's bytes.
    pub(super) offset: usize,
}

/// The data with which the bundles of a level are decoded.
#[derive(Debug)]
pub(super) struct LevelContext {
    pub(super) level: u32,
    pub(super) common: CommonSection,
    pub(super) page_dims: [u32; 2],
    pub(super) block_level: u32,
    /// Validators of pages, for threads to reuse.
    idle: Mutex<Vec<PageValidator>>,
}

/// A bundle that has been decoded and validated.
#[derive(Debug)]
pub(super) struct LoadedBundle {
    /// Its pages that are in the grid.
    pub(super) pages: Vec<LoadedPage>,
}

/// A page of a bundle.
#[derive(Debug)]
pub(super) struct LoadedPage {
    /// By its place along x and y.
    pub(super) place: [u32; 2],
    pub(super) words: Vec<u32>,
    /// Its blocks, see [`page_blocks`].
    pub(super) blocks: Vec<[u32; 2]>,
}

impl LevelContext {
    /// Reads the stored bytes of a level's common section.
    pub(super) fn parse(
        entry: &GridEntry,
        bytes: &[u8],
        encoding: Encoding,
        level: u32,
    ) -> Result<Arc<Self>, FormatError> {
        let common = entry.parse_common(bytes, encoding, level)?;
        let size = entry.grid.size;
        Ok(Arc::new(Self {
            level,
            common,
            page_dims: page_dims(size),
            block_level: block_level(size),
            idle: Mutex::default(),
        }))
    }

    /// Decodes and validates a bundle in the bytes of a request.
    pub(super) fn load(&self, stored: &Stored, bytes: &[u8]) -> Result<LoadedBundle, StreamError> {
        let Stored { index, place, entry, offset } = stored;
        let name = || name_of_bundle(self.level, *index as usize);
        let end = offset + entry.stored_bytes as usize;
        let Some(bytes) = bytes.get(*offset..end) else {
            let (needed, have) = (end as u64, bytes.len() as u64);
            return Err(FormatError::Truncated { what: name().into(), needed, have }.into());
        };
        let bundle = Bundle::parse(entry, bytes, &self.common, name)?;
        let pages = bundle.pages();
        let inside = pages_of(*place, self.page_dims).into_iter().zip(&pages);
        let inside: Vec<_> = inside.filter_map(|(place, page)| Some((place?, page))).collect();
        let common = self.common.words();
        let idle = || self.idle.lock().unwrap_or_else(|e| e.into_inner());
        let known = idle().pop();
        let mut validator = known.unwrap_or_else(|| PageValidator::new(common));
        let is_valid = inside.iter().try_for_each(|&(place, page)| validator.page(common, place, page));
        is_valid.map_err(|fault| FormatError::Depths { level: self.level, fault })?;
        // After a fault, the validator must not be used again.
        idle().push(validator);
        let load = |(place, page): &([u32; 2], &Page<'_>)| LoadedPage {
            place: *place,
            words: page.words.to_vec(),
            blocks: page_blocks(page, common, self.block_level),
        };
        Ok(LoadedBundle { pages: inside.iter().map(load).collect() })
    }
}
