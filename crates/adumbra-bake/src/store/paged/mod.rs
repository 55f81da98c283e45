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
word!(u16, u32);

/// A vector of words that supports appending and reading runs of words.
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

impl<T: Word> PagedVec<T> {
    /// Creates an empty vector. If there is a `spill`, words beyond its room go to disk.
    pub(crate) fn new(spill: Option<&Arc<Spill>>) -> Self {
        let paged = spill.map(|spill| Pages { spill: Arc::clone(spill), pages: Vec::new(), length: 0 });
        Self { whole: Vec::new(), paged }
    }

    pub(crate) fn len(&self) -> usize {
        self.paged.as_ref().map_or(self.whole.len(), |paged| paged.length)
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

    pub(crate) fn extend_from_slice(&mut self, words: &[T]) {
        match &mut self.paged {
            None => self.whole.extend_from_slice(words),
            Some(paged) => paged.extend(words),
        }
    }

    /// Calls `f` with the words from `at` on. `length` maps the first word to their number, at most `MOST`.
    pub(crate) fn with<const MOST: usize, R>(
        &self,
        at: usize,
        length: impl FnOnce(T) -> usize,
        f: impl FnOnce(&[T]) -> R,
    ) -> R {
        let Some(paged) = &self.paged else {
            return f(&self.whole[at..at + length(self.whole[at])]);
        };
        let mut buffer = [T::default(); MOST];
        // As many words as may be needed and are on one page.
        let known = MOST.min(words_per_page::<T>() - at % words_per_page::<T>()).min(paged.length - at);
        paged.read(at, &mut buffer[..known]);
        // Lost words may give any length.
        let length = length(buffer[0]).min(MOST).min(paged.length - at);
        if length > known {
            paged.read(at + known, &mut buffer[known..length]);
        }
        f(&buffer[..length])
    }
}

impl Pages {
    /// Appends words.
    fn extend<T: Word>(&mut self, words: &[T]) {
        let page = words_per_page::<T>();
        let (mut at, mut words) = (self.length, words);
        self.length += words.len();
        while self.pages.len() * page < self.length {
            self.pages.push(self.spill.new_page());
        }
        while !words.is_empty() {
            let (part, rest) = words.split_at(words.len().min(page - at % page));
            self.spill.write(self.pages[at / page], |bytes| {
                let bytes = bytes[at % page * size_of::<T>()..].chunks_exact_mut(size_of::<T>());
                bytes.zip(part).for_each(|(bytes, word)| word.to_bytes(bytes));
            });
            (at, words) = (at + part.len(), rest);
        }
    }

    /// Fills `words` with the words from `at` on.
    fn read<T: Word>(&self, at: usize, words: &mut [T]) {
        let page = words_per_page::<T>();
        let (mut at, mut words) = (at, words);
        while !words.is_empty() {
            let (part, rest) = words.split_at_mut(words.len().min(page - at % page));
            self.spill.read(self.pages[at / page], |bytes| {
                let bytes = bytes[at % page * size_of::<T>()..].chunks_exact(size_of::<T>());
                part.iter_mut().zip(bytes).for_each(|(word, bytes)| *word = T::from_bytes(bytes));
            });
            (at, words) = (at + part.len(), rest);
        }
    }
}

impl Drop for Pages {
    fn drop(&mut self) {
        self.pages.iter().for_each(|&page| self.spill.drop_page(page));
    }
}

const fn words_per_page<T>() -> usize {
    PAGE_BYTES / size_of::<T>()
}
