//! Bundles: an entry per bundle in a grid's table, and the words of a bundle.
//!
//! | bundle's word | meaning |
//! |---|---|
//! | 3·p | root of page p: uniform, in the common section, or in the page |
//! | 3·p + 1 | base of the root |
//! | 3·p + 2 | number of words of the page |
//! | from 48 on | the words of the pages, one after the other |
//!
//! In a coded file these words are coded, see [`CommonSection`].

use crate::error::FormatError;
use crate::file::common::{CommonSection, fault, is_plausible};
use crate::file::fields::{Decoder, reserved};
use crate::file::sections::{Section, checked};
use crate::layout::depths::page::{BUNDLE_PAGES, HEAD_WORDS, Page, pages_of};
use crate::layout::depths::{Range, Ranges, UNIFORM};
use crate::settings::Encoding;

/// Size of an entry of the table in bytes.
pub const BUNDLE_ENTRY_BYTES: usize = 24;
/// The entry's word 5: some column never switches.
const HAS_NEVER: u32 = 1;

/// An entry of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BundleEntry {
    /// Length in the file in bytes. 0 if all columns switch at the range's nearest depth.
    pub stored_bytes: u32,
    /// Length of the bundle's words in bytes.
    pub raw_bytes: u32,
    /// CRC-32 of the stored bytes.
    pub checksum: u32,
    /// Depths at which columns switch.
    pub range: Range,
}

impl BundleEntry {
    /// Encodes the entry.
    pub(super) fn encode(&self) -> [u8; BUNDLE_ENTRY_BYTES] {
        let flags = if self.range.has_never { HAS_NEVER } else { 0 };
        let Range { nearest, farthest, .. } = self.range;
        let words = [self.stored_bytes, self.raw_bytes, self.checksum, nearest, farthest, flags];
        let mut bytes = [0; BUNDLE_ENTRY_BYTES];
        bytes.as_chunks_mut().0.iter_mut().zip(words).for_each(|(b, word)| *b = word.to_le_bytes());
        bytes
    }

    /// Decodes an entry. `section` names the bundle.
    pub(super) fn parse(
        bytes: &[u8],
        encoding: Encoding,
        section: impl Fn() -> String,
    ) -> Result<Self, FormatError> {
        let [stored_bytes, raw_bytes, checksum, nearest, farthest, flags] = Decoder { bytes }.u32s()?;
        reserved("bundle's reserved bits", flags & !HAS_NEVER)?;
        let range = Range { nearest, farthest, has_never: flags & HAS_NEVER != 0 };
        let entry = Self { stored_bytes, raw_bytes, checksum, range };
        let shapes_bytes = u64::from(raw_bytes).checked_sub(4 * HEAD_WORDS as u64);
        let is_long = shapes_bytes.is_some_and(|bytes| bytes.is_multiple_of(4));
        let fits = match encoding {
            _ if stored_bytes == 0 => raw_bytes == 0 && checksum == 0 && range == Range::uniform(nearest),
            Encoding::Raw => is_long && raw_bytes == stored_bytes,
            Encoding::Coded => shapes_bytes.is_some_and(|bytes| is_plausible(stored_bytes.into(), bytes)),
        };
        if fits {
            return Ok(entry);
        }
        let expected = match encoding {
            Encoding::Raw => {
                "no bytes and one depth, or as many stored as raw bytes, in whole words, from 192 on"
            }
            Encoding::Coded => {
                "no bytes and one depth, or whole words of raw bytes, from 192 to 192 plus 16 times the stored ones"
            }
        };
        Err(fault(section, format!("{entry:?}"), expected))
    }

    /// Checks that the range is that of the bundle's pages, which are valid, and that nothing is stored where
    /// one depth suffices.
    pub(super) fn check_range(
        &self,
        pages: &[Page<'_>; BUNDLE_PAGES],
        (bundle, page_dims): ([u32; 2], [u32; 2]),
        ranges: &mut Ranges<'_>,
        section: impl Fn() -> String,
    ) -> Result<(), FormatError> {
        if self.stored_bytes == 0 {
            return Ok(());
        }
        let (range, is_uniform) = range_of(bundle, page_dims, pages, ranges);
        if is_uniform {
            return Err(fault(section, "bytes although all columns switch at one depth", "none"));
        }
        if range != self.range {
            return Err(fault(section, format!("{:?}", self.range), "the range of depths of its columns"));
        }
        Ok(())
    }
}

/// A bundle as it is stored.
#[derive(Clone, Debug)]
pub struct StoredBundle {
    pub(super) entry: BundleEntry,
    pub(super) bytes: Vec<u8>,
}

impl StoredBundle {
    /// Encodes the pages of the bundle at this place, in a grid of `page_dims` pages.
    ///
    /// # Errors
    /// Returns [`FormatError::Uncodable`] if the file is coded and the pages are not laid out as bakes do.
    pub fn new(
        bundle: [u32; 2],
        page_dims: [u32; 2],
        pages: &[Page<'_>; BUNDLE_PAGES],
        ranges: &mut Ranges<'_>,
        common: &CommonSection,
    ) -> Result<Self, FormatError> {
        let (range, is_uniform) = range_of(bundle, page_dims, pages, ranges);
        if is_uniform {
            let entry = BundleEntry { stored_bytes: 0, raw_bytes: 0, checksum: 0, range };
            return Ok(Self { entry, bytes: Vec::new() });
        }
        let [x, y] = bundle;
        let bytes = common.bundle_to_bytes(pages, format_args!("bundle ({x}, {y})"))?;
        let entry = BundleEntry {
            stored_bytes: bytes.len() as u32,
            raw_bytes: raw_bytes(bundle, page_dims, pages) as u32,
            checksum: crc32fast::hash(&bytes),
            range,
        };
        Ok(Self { entry, bytes })
    }
}

/// A bundle's pages, decoded.
#[derive(Debug)]
pub struct Bundle {
    heads: [[u32; 3]; BUNDLE_PAGES],
    words: Vec<u32>,
}

impl Bundle {
    /// Decodes the stored bytes of a bundle. `section` names it.
    ///
    /// # Errors
    /// Returns the fault with the values found.
    pub fn parse(
        entry: &BundleEntry,
        bytes: &[u8],
        common: &CommonSection,
        section: impl Fn() -> String,
    ) -> Result<Self, FormatError> {
        let whole = Section { offset: 0, length: bytes.len() as u64, checksum: entry.checksum };
        checked(bytes, whole, &section)?;
        if entry.stored_bytes == 0 {
            return Ok(Self { heads: [[UNIFORM, entry.range.nearest, 0]; BUNDLE_PAGES], words: Vec::new() });
        }
        let mut words = common.parse_bundle(bytes, entry.raw_bytes, &section)?;
        let heads: [[u32; 3]; BUNDLE_PAGES] =
            std::array::from_fn(|page| [0, 1, 2].map(|field| words[3 * page + field]));
        words.drain(..HEAD_WORDS);
        let sum: u64 = heads.iter().map(|head| u64::from(head[2])).sum();
        if sum != words.len() as u64 {
            let found = format!("{sum} words of pages");
            let expected = "as many words of pages as the bundle has after its head";
            return Err(fault(section, found, expected));
        }
        Ok(Self { heads, words })
    }

    /// Returns the pages. Those outside the grid are as they are stored.
    pub fn pages(&self) -> [Page<'_>; BUNDLE_PAGES] {
        let mut first = 0;
        self.heads.map(|[root, base, words]| {
            let from = first;
            first += words as usize;
            Page { root, base, words: &self.words[from..first] }
        })
    }

    /// Checks what the tree does not show: that pages outside the grid and uniform pages are as writers write
    /// them.
    pub(super) fn check_pages(
        &self,
        entry: &BundleEntry,
        (bundle, page_dims): ([u32; 2], [u32; 2]),
        section: impl Fn() -> String,
    ) -> Result<(), FormatError> {
        if entry.stored_bytes == 0 {
            return Ok(());
        }
        for (place, page) in pages_of(bundle, page_dims).into_iter().zip(&self.pages()) {
            if place.is_none() && *page != Page::OUTSIDE {
                return Err(fault(&section, "something outside the grid", "no switches there"));
            }
            if page.root == UNIFORM && !page.words.is_empty() {
                return Err(fault(&section, "words in a uniform page", "none"));
            }
        }
        Ok(())
    }
}

/// Returns the length in bytes of a bundle's words. 0 if all of its columns switch at one depth.
pub(super) fn raw_bytes(bundle: [u32; 2], page_dims: [u32; 2], pages: &[Page<'_>; BUNDLE_PAGES]) -> u64 {
    if is_uniform(&inside(bundle, page_dims, pages)) {
        return 0;
    }
    4 * (HEAD_WORDS + pages.iter().map(|page| page.words.len()).sum::<usize>()) as u64
}

/// Returns the pages of a bundle that are inside the grid.
fn inside<'w>(bundle: [u32; 2], page_dims: [u32; 2], pages: &[Page<'w>; BUNDLE_PAGES]) -> Vec<Page<'w>> {
    let inside = pages_of(bundle, page_dims).into_iter().zip(pages).filter(|(place, _)| place.is_some());
    inside.map(|(_, page)| *page).collect()
}

/// Whether all columns of some pages switch at one depth.
fn is_uniform(pages: &[Page<'_>]) -> bool {
    pages.iter().all(|page| *page == Page::uniform(pages[0].base))
}

/// Returns the range of a bundle's pages that are inside the grid, and whether all of their columns switch at
/// one depth.
fn range_of(
    bundle: [u32; 2],
    page_dims: [u32; 2],
    pages: &[Page<'_>; BUNDLE_PAGES],
    ranges: &mut Ranges<'_>,
) -> (Range, bool) {
    let inside = inside(bundle, page_dims, pages);
    let range = inside.iter().map(|page| ranges.of_page(page)).reduce(Range::joined);
    (range.unwrap_or(Range::NEVER), is_uniform(&inside))
}
