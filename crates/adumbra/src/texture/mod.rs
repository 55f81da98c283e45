//! Words as RGBA8 pictures, saved and loaded bit for bit. Source: *The Optimization and realization of Compact
//! Precomputed Voxelized Shadows Algorithm* (2021), §3.3.2: a 32-bit word is a pixel, R = bits 7..0, G = 15..8,
//! B = 23..16, A = 31..24.
//!
//! Departures: words that do not fit one picture go on in further pages; behind the words may stand other bytes (a file's
//! header), as words padded with zeros; the last row of every page is a signature (`signature.rs`), so that a page that
//! was cropped, resized, or passed through a lossy or colour-managing program is refused and not misread.
//!
//! The root is pixel (0, 0) of page 0; [`Layout`] has the rule for every other word. Worked value: the word `0xc000_00f0`
//! is the pixel R = 240, G = 0, B = 0, A = 192.

mod error;
mod files;
mod join;
mod layout;
mod png;
mod signature;

pub use error::TextureError;
pub use files::{Written, page_path, read, write};
pub use layout::Layout;

use join::Joiner;
use signature::Signature;

/// Least value of the largest side, pixels.
pub const MIN_SIDE: u32 = 64;
/// Most pixels a side: what every GPU of today takes.
pub const MAX_SIDE: u32 = 8192;
/// Most pages of an export.
pub const MAX_PAGES: u32 = 4096;
/// The narrowest page: a signature fits its row.
const MIN_WIDTH: u32 = 16;

/// One picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page {
    /// Pixels a row.
    pub width: u32,
    /// Rows, the signature's among them.
    pub height: u32,
    /// Four bytes a pixel, rows from the top.
    pub rgba: Vec<u8>,
}

/// `words`, and `rest` behind them, as pages of at most `max_side` pixels a side.
///
/// # Errors
/// [`TextureError::Side`], [`TextureError::TooManyPages`].
pub fn encode(words: &[u32], rest: &[u8], max_side: u32) -> Result<Vec<Page>, TextureError> {
    let stream = Stream::new(words, rest, max_side)?;
    Ok((0..stream.layout.pages).map(|page| stream.page(page)).collect())
}

/// The words and the rest of pages in order.
///
/// # Errors
/// [`TextureError`] where they are not exactly the pages of one export.
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

/// What is to be written, and where each part goes.
struct Stream<'a> {
    words: &'a [u32],
    rest: &'a [u8],
    layout: Layout,
    checksum: u32,
}

/// Words that are turned to bytes at a time.
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
