//! Joins pages back into words: each page is checked by itself, then against page 0.

use crate::tree::error::TextureError;
use crate::tree::texture::Page;
use crate::tree::texture::signature::Signature;

/// Takes the pages in order.
#[derive(Default)]
pub(crate) struct Joiner {
    first: Option<Signature>,
    taken: u32,
    words: Vec<u32>,
    rest: Vec<u8>,
    hasher: crc32fast::Hasher,
}

impl Joiner {
    /// Number of the next page; `None` after the last.
    pub(crate) fn next_page(&self) -> Option<u32> {
        match self.first {
            Some(first) if self.taken == first.pages => None,
            _ => Some(self.taken),
        }
    }

    /// Number of pages according to page 0; 0 before page 0 was added.
    pub(crate) fn pages(&self) -> u32 {
        self.first.map_or(0, |first| first.pages)
    }

    pub(crate) fn add(&mut self, page: &Page) -> Result<(), TextureError> {
        let found = Signature::of(page)?;
        let first = *self.first.get_or_insert(found);
        let whole = |s: &Signature| (s.width, s.pages, s.words, s.rest_bytes, s.stream_checksum);
        if whole(&found) != whole(&first) {
            return Err(TextureError::MixedExports { page: self.taken });
        }
        if found.page != self.taken {
            return Err(TextureError::MisplacedPage { found: found.page, expected: self.taken });
        }
        // The same words in pages of another height belong to another export.
        let layout = first.layout();
        let expected = (layout.page_words(found.page), layout.height(found.page));
        if (u64::from(found.page_words), found.height) != expected {
            return Err(TextureError::MixedExports { page: self.taken });
        }
        self.taken += 1;
        let pixels = &page.rgba[..4 * found.page_words as usize];
        self.hasher.update(pixels);
        let words_left = first.words as usize - self.words.len();
        let (words, rest) = pixels.split_at(pixels.len().min(words_left.saturating_mul(4)));
        self.words.extend(words.as_chunks().0.iter().map(|&b| u32::from_le_bytes(b)));
        self.rest.extend_from_slice(rest);
        Ok(())
    }

    pub(crate) fn finish(mut self) -> Result<(Vec<u32>, Vec<u8>), TextureError> {
        let Some(first) = self.first else { return Err(TextureError::NoPages) };
        if self.taken < first.pages {
            return Err(TextureError::MissingPage { page: self.taken, pages: first.pages });
        }
        let (stored, computed) = (first.stream_checksum, self.hasher.finalize());
        if stored != computed {
            return Err(TextureError::StreamChecksum { stored, computed });
        }
        self.rest.truncate(first.rest_bytes as usize);
        Ok((self.words, self.rest))
    }
}
