//! Vectors of words that grow at the end, either entirely in memory or in pages, some of which are on disk.

mod spill;
#[cfg(test)]
mod tests;

use std::sync::Arc;

pub(crate) use spill::{PAGE_BYTES, Spill};

/// An element of a [`PagedVec`].
pub(crate) trait Word: Copy + Default + Eq {
    /// Converts from little-endian bytes, as many as the word has.
    fn from_bytes(bytes: &[u8]) -> Self;
    /// Converts to little-endian bytes, as many as the word has.
    fn to_bytes(self, bytes: &mut [u8]);
}

macro_rules! word {
    ($($t:ty),*) => {$(
        impl Word for $t {
            fn from_bytes(bytes: &[u8]) -> Self {
                bytes.first_chunk().map_or(0, |&b| Self::from_le_bytes(b))
            }

            fn to_bytes(self, bytes: &mut [u8]) {
                bytes.copy_from_slice(&self.to_le_bytes());
            }
        }
    )*};
}
word!(u16, u32, u64);

/// A vector of words that supports reading, appending and overwriting runs of words.
pub(crate) struct PagedVec<T> {
    /// All words, if there is no spill.
    whole: Vec<T>,
    /// The pages that hold the words, if there is a spill.
    paged: Option<Pages>,
}

struct Pages {
    spill: Arc<Spill>,
    pages: Vec<u32>,
    /// Number of words.
    length: usize,
}

impl<T> Default for PagedVec<T> {
    fn default() -> Self {
        Self { whole: Vec::new(), paged: None }
    }
}

impl<T: Word> PagedVec<T> {
    const PAGE: usize = PAGE_BYTES / size_of::<T>();

    /// Creates an empty vector. If there is a `spill`, words beyond its room go to disk.
    pub(crate) fn new(spill: Option<&Arc<Spill>>) -> Self {
        let paged = spill.map(|spill| Pages { spill: Arc::clone(spill), pages: Vec::new(), length: 0 });
        Self { whole: Vec::new(), paged }
    }

    /// Whether words may be on disk.
    pub(crate) fn is_paged(&self) -> bool {
        self.paged.is_some()
    }

    /// Whether words may have been lost, which then read as zeros; see [`Spill::check`].
    pub(crate) fn has_failed(&self) -> bool {
        self.paged.as_ref().is_some_and(|paged| paged.spill.has_failed())
    }

    pub(crate) fn len(&self) -> usize {
        self.paged.as_ref().map_or(self.whole.len(), |paged| paged.length)
    }

    /// Reserves room for this many more words if all words are in memory.
    pub(crate) fn reserve_exact(&mut self, words: usize) {
        if self.paged.is_none() {
            self.whole.reserve_exact(words);
        }
    }

    /// Frees unused capacity.
    pub(crate) fn shrink_to_fit(&mut self) {
        self.whole.shrink_to_fit();
    }

    /// Bytes held apart from the spill's pages.
    pub(crate) fn memory_bytes(&self) -> usize {
        let pages = self.paged.as_ref().map_or(0, |paged| paged.pages.capacity());
        self.whole.capacity() * size_of::<T>() + pages * 4
    }

    pub(crate) fn push(&mut self, word: T) {
        if self.paged.is_none() {
            self.whole.push(word);
        } else {
            self.extend_from_slice(&[word]);
        }
    }

    pub(crate) fn extend_from_slice(&mut self, words: &[T]) {
        let Some(Pages { spill, pages, length }) = &mut self.paged else {
            return self.whole.extend_from_slice(words);
        };
        let from = *length;
        *length += words.len();
        while pages.len() * Self::PAGE < *length {
            pages.push(spill.new_page());
        }
        self.overwrite(from, words);
    }

    pub(crate) fn get(&self, at: usize) -> T {
        match &self.paged {
            None => self.whole[at],
            Some(Pages { spill, pages, .. }) => {
                spill.read(pages[at / Self::PAGE], |bytes| word_in(bytes, at % Self::PAGE))
            }
        }
    }

    /// Calls `f` with the words from `at` on. `length` maps the first word to their number, at most `MOST`.
    pub(crate) fn with<const MOST: usize, R>(
        &self,
        at: usize,
        length: impl FnOnce(T) -> usize,
        f: impl FnOnce(&[T]) -> R,
    ) -> R {
        if self.paged.is_none() {
            return f(&self.whole[at..at + length(self.whole[at])]);
        }
        let mut buffer = [T::default(); MOST];
        // As many words as may be needed and are on one page.
        let known = MOST.min(Self::PAGE - at % Self::PAGE).min(self.len() - at);
        self.read(at, &mut buffer[..known]);
        // Lost words may give any length.
        let length = length(buffer[0]).min(MOST).min(self.len() - at);
        if length > known {
            self.read(at + known, &mut buffer[known..length]);
        }
        f(&buffer[..length])
    }

    /// Overwrites words from `at` on.
    pub(crate) fn overwrite(&mut self, at: usize, words: &[T]) {
        let Some(Pages { spill, pages, .. }) = &self.paged else {
            return self.whole[at..at + words.len()].copy_from_slice(words);
        };
        let mut at = at;
        let mut words = words;
        while !words.is_empty() {
            let (part, rest) = words.split_at(words.len().min(Self::PAGE - at % Self::PAGE));
            spill.write(pages[at / Self::PAGE], |bytes| {
                let bytes = bytes[at % Self::PAGE * size_of::<T>()..].chunks_exact_mut(size_of::<T>());
                bytes.zip(part).for_each(|(bytes, word)| word.to_bytes(bytes));
            });
            (at, words) = (at + part.len(), rest);
        }
    }

    /// Fills `words` with the words from `at` on.
    pub(crate) fn read(&self, at: usize, words: &mut [T]) {
        let Some(Pages { spill, pages, .. }) = &self.paged else {
            return words.copy_from_slice(&self.whole[at..at + words.len()]);
        };
        let mut at = at;
        let mut words = words;
        while !words.is_empty() {
            let (part, rest) = words.split_at_mut(words.len().min(Self::PAGE - at % Self::PAGE));
            spill.read(pages[at / Self::PAGE], |bytes| {
                let bytes = bytes[at % Self::PAGE * size_of::<T>()..].chunks_exact(size_of::<T>());
                part.iter_mut().zip(bytes).for_each(|(word, bytes)| *word = T::from_bytes(bytes));
            });
            (at, words) = (at + part.len(), rest);
        }
    }

    /// Loads all words into memory, releasing pages on the way.
    pub(crate) fn into_vec(mut self) -> Vec<T> {
        let length = self.len();
        let Some(Pages { spill, pages, .. }) = &mut self.paged else {
            return std::mem::take(&mut self.whole);
        };
        let mut words = Vec::with_capacity(length);
        for page in pages.drain(..) {
            let count = Self::PAGE.min(length - words.len());
            spill.read(page, |bytes| words.extend((0..count).map(|at| word_in::<T>(bytes, at))));
            spill.drop_page(page);
        }
        words
    }
}

impl<T> Drop for PagedVec<T> {
    fn drop(&mut self) {
        if let Some(Pages { spill, pages, .. }) = &self.paged {
            pages.iter().for_each(|&page| spill.drop_page(page));
        }
    }
}

fn word_in<T: Word>(bytes: &[u8], at: usize) -> T {
    T::from_bytes(&bytes[at * size_of::<T>()..][..size_of::<T>()])
}
