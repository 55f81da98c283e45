//! The last row of a page: a description of the page, and checksums that reveal any change to it.
//!
//! | pixel | meaning |
//! |---|---|
//! | 0, 1 | magic: the bytes `ADUMPAGE` |
//! | 2 | version, 1 |
//! | 3, 4 | width and height of the page, including this row |
//! | 5, 6 | number of the page, from 0; number of pages |
//! | 7 | words on this page, including those of the rest |
//! | 8 | total number of words, without those of the rest |
//! | 9 | bytes of the rest |
//! | 10 | CRC-32 of all words and the rest, as bytes, the rest padded with zeros to whole words |
//! | 11 | CRC-32 of this page's pixels above this row |
//! | 12 | CRC-32 of this row's other pixels |
//! | from 13 | zero |

use crate::tree::error::TextureError;
use crate::tree::texture::layout::{Layout, pages_for};
use crate::tree::texture::{MAX_PAGES, MAX_SIDE, MIN_WIDTH, Page};

pub(crate) const MAGIC: [u8; 8] = *b"ADUMPAGE";
/// The version that is written and read.
pub(crate) const VERSION: u32 = 1;
/// Byte offset of the row's own checksum.
const CHECKSUM_AT: usize = 48;

/// The description that a page carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Signature {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) page: u32,
    pub(crate) pages: u32,
    pub(crate) page_words: u32,
    pub(crate) words: u32,
    pub(crate) rest_bytes: u32,
    pub(crate) stream_checksum: u32,
    pub(crate) page_checksum: u32,
}

impl Signature {
    /// Appends the row to the pixels.
    pub(crate) fn append_to(&self, rgba: &mut Vec<u8>) {
        let start = rgba.len();
        rgba.extend_from_slice(&MAGIC);
        let fields = [
            VERSION,
            self.width,
            self.height,
            self.page,
            self.pages,
            self.page_words,
            self.words,
            self.rest_bytes,
            self.stream_checksum,
            self.page_checksum,
            0,
        ];
        rgba.extend(fields.iter().flat_map(|f| f.to_le_bytes()));
        rgba.resize(start + 4 * self.width as usize, 0);
        let row = &mut rgba[start..];
        let checksum = row_checksum(row);
        row[CHECKSUM_AT..CHECKSUM_AT + 4].copy_from_slice(&checksum.to_le_bytes());
    }

    /// Finds and checks the signature of `page`, then checks the size and pixels of the page against it.
    pub(crate) fn of(page: &Page) -> Result<Self, TextureError> {
        let (width, height) = (page.width, page.height);
        let row_bytes = 4 * width as usize;
        if width == 0 || height == 0 || Some(page.rgba.len()) != row_bytes.checked_mul(height as usize) {
            return Err(TextureError::PageBytes { width, height, bytes: page.rgba.len() });
        }
        let (above, row) = page.rgba.split_at(page.rgba.len() - row_bytes);
        if !row.starts_with(&MAGIC) {
            return Err(match above.chunks_exact(row_bytes).position(|r| r.starts_with(&MAGIC)) {
                Some(row) => TextureError::SignatureMoved { row: row as u32, last: height - 1 },
                None => TextureError::NoSignature { width, height },
            });
        }
        let fields = row.as_chunks::<4>().0;
        // A cropped row may end before its checksum.
        let field = |i: usize| fields.get(i).map_or(0, |&b| u32::from_le_bytes(b));
        let signature = Self {
            width: field(3),
            height: field(4),
            page: field(5),
            pages: field(6),
            page_words: field(7),
            words: field(8),
            rest_bytes: field(9),
            stream_checksum: field(10),
            page_checksum: field(11),
        };
        let expected = [signature.width, signature.height];
        // The remaining fields of a row that was cropped at its end still give the original size, so the size
        // is checked before the checksum.
        let plausible = expected.iter().all(|side| (1..=MAX_SIDE).contains(side));
        let (stored, computed) = (field(12), row_checksum(row));
        if expected != [width, height] && (plausible || stored == computed) {
            return Err(TextureError::WrongSize { found: [width, height], expected });
        }
        if stored != computed {
            return Err(TextureError::SignatureChecksum { stored, computed });
        }
        if field(2) != VERSION {
            return Err(TextureError::Version { version: field(2), supported: VERSION });
        }
        signature.check()?;
        let (stored, computed) = (signature.page_checksum, crc32fast::hash(above));
        if stored != computed {
            return Err(TextureError::PageChecksum { stored, computed });
        }
        Ok(signature)
    }

    /// Total number of words, including those of the rest.
    fn stream_words(&self) -> u64 {
        u64::from(self.words) + u64::from(self.rest_bytes.div_ceil(4))
    }

    /// Returns the layout that page 0 implies.
    pub(crate) fn layout(&self) -> Layout {
        let (width, rows) = (self.width, self.height - 1);
        Layout { width, rows, pages: self.pages, stream_words: self.stream_words() }
    }

    /// Checks that the fields are possible for a layout.
    fn check(&self) -> Result<(), TextureError> {
        let refuse = |field, value: u32, expected: String| {
            Err(TextureError::SignatureField { field, value: value.into(), expected })
        };
        if !self.width.is_power_of_two() || self.width < MIN_WIDTH {
            return refuse("width", self.width, format!("a power of two from {MIN_WIDTH}"));
        }
        if !(1..=MAX_PAGES).contains(&self.pages) {
            return refuse("pages", self.pages, format!("from 1 to {MAX_PAGES}"));
        }
        if self.page >= self.pages {
            return refuse("page", self.page, format!("below {}", self.pages));
        }
        if self.page == 0 {
            let expected = pages_for(self.stream_words(), self.width, self.height - 1);
            if u64::from(self.pages) != expected {
                return refuse("pages", self.pages, expected.to_string());
            }
            let layout = self.layout();
            if u64::from(self.page_words) != layout.page_words(0) || self.height != layout.height(0) {
                let expected = format!("{}, in {} rows", layout.page_words(0), layout.height(0));
                return refuse("page words", self.page_words, expected);
            }
        }
        Ok(())
    }
}

/// Returns the CRC-32 of the row without its own checksum.
fn row_checksum(row: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&row[..CHECKSUM_AT.min(row.len())]);
    hasher.update(row.get(CHECKSUM_AT + 4..).unwrap_or_default());
    hasher.finalize()
}
