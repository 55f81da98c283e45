//! Words as RGBA8 textures, saved and loaded bit for bit. Source: *The Optimization and realization of
//! Compact Precomputed Voxelized Shadows Algorithm* (2021), §3.3.2: a 32-bit word is a pixel, R = bits 7..0,
//! G = 15..8, B = 23..16, A = 31..24.
//!
//! Departures: words that do not fit one page continue on further pages. The words may be followed by other
//! bytes (the header of a file), stored as words padded with zeros. The last row of every page is a signature
//! (`signature.rs`), so that a page that was cropped, resized, or passed through a lossy or colour-managing
//! program is refused and not misread.
//!
//! The root is pixel (0, 0) of page 0; [`Layout`] has the rule for every other word. Worked value: the word
//! `0xc000_00f0` is the pixel R = 240, G = 0, B = 0, A = 192.

mod files;
mod join;
mod layout;
mod png;
mod signature;

pub use crate::tree::page_limits::{MAX_PAGES, MAX_SIDE, MIN_SIDE};
pub use files::{ExportSummary, page_path, read, write};
pub use layout::Layout;

use crate::tree::error::TextureError;
use join::Joiner;
use signature::Signature;

/// The minimum width of a page: one row holds a signature.
const MIN_WIDTH: u32 = 16;

/// One page of an export.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows, including that of the signature.
    pub height: u32,
    /// Four bytes per pixel, rows from the top.
    pub rgba: Vec<u8>,
}

/// Encodes `words`, followed by `rest`, as pages of at most `max_side` pixels per side.
///
/// # Errors
/// Returns [`TextureError::Side`] or [`TextureError::TooManyPages`].
pub fn encode(words: &[u32], rest: &[u8], max_side: u32) -> Result<Vec<Page>, TextureError> {
    let stream = Stream::new(words, rest, max_side)?;
    Ok((0..stream.layout.pages).map(|page| stream.page(page)).collect())
}

/// Decodes the words and the rest from pages in order.
///
/// # Errors
/// Returns [`TextureError`] if they are not exactly the pages of one export.
pub fn decode(pages: &[Page]) -> Result<(Vec<u32>, Vec<u8>), TextureError> {
    let mut joiner = Joiner::default();
    for page in pages {
        if joiner.next_page().is_none() {
            return Err(TextureError::ExtraPages { given: pages.len(), pages: joiner.pages() });
        }
        joiner.add(page)?;
    }
    joiner.finish()
}

/// The data to be written, with its layout.
struct Stream<'a> {
    words: &'a [u32],
    rest: &'a [u8],
    layout: Layout,
    checksum: u32,
}

/// Number of words converted to bytes at a time.
const CHUNK_WORDS: usize = 1 << 14;

impl<'a> Stream<'a> {
    fn new(words: &'a [u32], rest: &'a [u8], max_side: u32) -> Result<Self, TextureError> {
        let layout = Layout::new(words.len(), rest.len(), max_side)?;
        let mut hasher = crc32fast::Hasher::new();
        let mut bytes = Vec::with_capacity(4 * CHUNK_WORDS);
        for chunk in words.chunks(CHUNK_WORDS) {
            bytes.clear();
            bytes.extend(chunk.iter().flat_map(|w| w.to_le_bytes()));
            hasher.update(&bytes);
        }
        hasher.update(rest);
        hasher.update(&[0; 4][..rest.len().next_multiple_of(4) - rest.len()]);
        Ok(Self { words, rest, layout, checksum: hasher.finalize() })
    }

    fn page(&self, page: u32) -> Page {
        let Layout { width, pages, .. } = self.layout;
        let (height, page_words) = (self.layout.height(page), self.layout.page_words(page));
        let from = u64::from(page) * self.layout.page_words(0);
        let to = from + page_words;
        let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
        let end = self.words.len();
        let words = &self.words[(from as usize).min(end)..(to as usize).min(end)];
        rgba.extend(words.iter().flat_map(|w| w.to_le_bytes()));
        let rest_at = |word: u64| (4 * (word as usize).saturating_sub(end)).min(self.rest.len());
        rgba.extend_from_slice(&self.rest[rest_at(from)..rest_at(to)]);
        rgba.resize(4 * width as usize * (height as usize - 1), 0);
        let signature = Signature {
            width,
            height,
            page,
            pages,
            page_words: page_words as u32,
            words: self.words.len() as u32,
            rest_bytes: self.rest.len() as u32,
            stream_checksum: self.checksum,
            page_checksum: crc32fast::hash(&rgba),
        };
        signature.append_to(&mut rgba);
        Page { width, height, rgba }
    }
}
