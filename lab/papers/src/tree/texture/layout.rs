//! The position of each word: page and pixel.
//!
//! Word i is pixel `i mod (width · rows)` of page `i / (width · rows)`, counted along rows from the top left:
//! x is the remainder of that index by `width`, y its quotient. The width is a power of two and equal for all
//! pages. All pages but the last have the same number of rows. Worked value: with width 16 and 15 rows, word
//! 250 is page 1, x = 10, y = 0.

use crate::tree::error::TextureError;
use crate::tree::texture::{MAX_PAGES, MAX_SIDE, MIN_SIDE, MIN_WIDTH};

/// The size and number of the pages of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Pixels per row, a power of two.
    pub width: u32,
    /// Rows of words on every page but the last; the signature comes below them.
    pub rows: u32,
    /// Number of pages.
    pub pages: u32,
    /// Total number of words, including those of `rest`.
    pub stream_words: u64,
}

impl Layout {
    /// Computes the layout of `words` words followed by `rest_bytes` bytes: one page, roughly square, if one
    /// is enough, else pages as large as `max_side` allows.
    ///
    /// # Errors
    /// Returns [`TextureError::Side`] or [`TextureError::TooManyPages`].
    pub fn new(words: usize, rest_bytes: usize, max_side: u32) -> Result<Self, TextureError> {
        if !(MIN_SIDE..=MAX_SIDE).contains(&max_side) {
            return Err(TextureError::Side { max_side });
        }
        let stream_words = words as u64 + rest_bytes.div_ceil(4) as u64;
        let widest = 1 << max_side.ilog2();
        let mut width = MIN_WIDTH;
        while width < widest && stream_words > u64::from(width) * u64::from(width) {
            width *= 2;
        }
        let rows = stream_words.div_ceil(width.into()).min(u64::from(max_side) - 1) as u32;
        let pages = pages_for(stream_words, width, rows);
        // The signature stores the counts of words and bytes in 32 bits.
        let countable = words.max(rest_bytes) as u64 <= u64::from(u32::MAX);
        if !countable || pages > u64::from(MAX_PAGES) {
            return Err(TextureError::TooManyPages { words: stream_words, pages });
        }
        Ok(Self { width, rows, pages: pages as u32, stream_words })
    }

    /// Returns page, x and y of a word.
    pub fn locate(&self, word: u64) -> [u64; 3] {
        let within = word % self.page_capacity();
        let width = u64::from(self.width);
        [word / self.page_capacity(), within % width, within / width]
    }

    /// Returns the number of words on a page, without the padding of its last row.
    pub(crate) fn page_words(&self, page: u32) -> u64 {
        let before = u64::from(page) * self.page_capacity();
        self.stream_words.saturating_sub(before).min(self.page_capacity())
    }

    /// Returns the rows of a page, including its signature.
    pub fn height(&self, page: u32) -> u32 {
        self.page_words(page).div_ceil(self.width.into()) as u32 + 1
    }

    fn page_capacity(&self) -> u64 {
        (u64::from(self.width) * u64::from(self.rows)).max(1)
    }
}

/// Returns the number of pages of `rows` rows that the words need; at least one, which contains only a
/// signature if there are no words.
pub(crate) fn pages_for(stream_words: u64, width: u32, rows: u32) -> u64 {
    let capacity = u64::from(width) * u64::from(rows);
    stream_words.div_ceil(capacity.max(1)).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layout_worked_values() {
        let small = Layout::new(200, 160, 64).unwrap();
        assert_eq!(small, Layout { width: 16, rows: 15, pages: 1, stream_words: 240 });
        assert_eq!(small.locate(0), [0, 0, 0]);
        assert_eq!(Layout { stream_words: 251, pages: 2, ..small }.locate(250), [1, 10, 0]);
        assert_eq!(small.height(0), 16);
        let paged = Layout::new(64 * 63 * 2 + 1, 0, 64).unwrap();
        assert_eq!((paged.width, paged.rows, paged.pages), (64, 63, 3));
        assert_eq!([0, 1, 2].map(|p| paged.page_words(p)), [4032, 4032, 1]);
        assert_eq!([0, 1, 2].map(|p| paged.height(p)), [64, 64, 2]);
    }

    #[test]
    fn layout_stays_within_the_side_and_holds_every_word() {
        for max_side in [64, 65, 100, 127, 128, 300, 8191, 8192] {
            for words in [0_usize, 1, 15, 16, 17, 255, 256, 257, 4031, 4032, 4033, 4096, 65_537, 1_000_000] {
                let layout = Layout::new(words, 5, max_side).unwrap();
                assert!(layout.width.is_power_of_two() && layout.width <= max_side);
                let held: u64 = (0..layout.pages).map(|p| layout.page_words(p)).sum();
                assert_eq!(held, words as u64 + 2);
                for page in 0..layout.pages {
                    assert!(layout.page_words(page) > 0 && layout.height(page) <= max_side);
                }
            }
        }
        assert_eq!(Layout::new(0, 0, 64).unwrap().pages, 1);
        for max_side in [0, 63, 8193] {
            assert_eq!(Layout::new(1, 0, max_side), Err(TextureError::Side { max_side }));
        }
        let error = Layout::new(64 * 63 * 4096 + 1, 0, 64).unwrap_err();
        assert!(matches!(error, TextureError::TooManyPages { pages: 4097, .. }));
    }
}
