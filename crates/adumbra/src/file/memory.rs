//! The memory that a file takes, computed from its header, directory and tables alone.

use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

use crate::coder::DECODING_RATIO;
use crate::error::{Error, FormatError, IoError, Result};
use crate::file::contents::tables_end;
use crate::file::header::directory_bytes;
use crate::file::{BundleEntry, Contents, GridEntry, HEADER_BYTES, MAX_LEVELS, ShadowFile, threads};
use crate::layout::depths::page::HEAD_WORDS;
use crate::layout::depths::{PLACED_PAGE_BYTES, page, top};

/// Memory that coding a part takes in addition to its words, as a multiple of them: its shapes, and the
/// tables that find equal shapes. `docs/figures.md` has the measurement.
pub const CODING_RATIO: u64 = 24;

/// Number of bundles that are decoded at a time. Their words are in memory twice until they are in the tree.
pub(super) const BATCH_BUNDLES: usize = 64;

/// Largest length that is counted. The lengths in a file are not verified yet, and are multiplied.
const MOST_BYTES: u64 = 1 << 50;

/// The memory that a shadow file takes, for programs with a limit on theirs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FileMemory {
    /// Bytes of all levels, once they are read.
    pub held_bytes: u64,
    /// Peak bytes while the file is read, including the levels read so far. Approximate: rounding by the
    /// allocator is not counted.
    pub peak_bytes: u64,
    /// Peak bytes while the file is written again in coded form, including the levels held.
    pub writing_bytes: u64,
}

impl FileMemory {
    /// Returns the memory of a file. `first(n)` returns the first `n` bytes of the file, or all if it is
    /// shorter.
    pub(crate) fn of(
        mut first: impl FnMut(u64) -> Result<Vec<u8>>,
        invalid: impl Fn(FormatError) -> Error,
    ) -> Result<Self> {
        // Header and directory of the most levels, in one read.
        let front = first((HEADER_BYTES + directory_bytes(MAX_LEVELS)) as u64)?;
        let bytes = first(tables_end(&front).map_err(&invalid)?)?;
        Ok(Self::of_contents(&Contents::parse_beginning(&bytes).map_err(invalid)?))
    }

    fn of_contents(Contents { header, grids, tables }: &Contents) -> Self {
        let tables_bytes = tables.iter().map(|table| size_of_val(&table[..]) as u64).sum::<u64>();
        let mut memory = Self::default();
        let mut coding = 0;
        for (grid, table) in grids.iter().zip(tables) {
            memory.held_bytes += held_bytes(grid, table);
            memory.peak_bytes = memory.peak_bytes.max(memory.held_bytes + decoding_bytes(grid, table));
            coding = coding.max(CODING_RATIO * shapes_bytes(grid, table));
        }
        memory.writing_bytes = memory.held_bytes + coding;
        memory.peak_bytes += header.file_bytes.min(MOST_BYTES) + tables_bytes;
        memory
    }

    /// Checks that a file can be read within a limit.
    ///
    /// # Errors
    /// Returns [`FormatError::TooLarge`] if it cannot.
    pub(super) fn check(contents: &Contents, limit_bytes: u64) -> Result<(), FormatError> {
        let needed_bytes = Self::of_contents(contents).peak_bytes;
        if needed_bytes > limit_bytes {
            return Err(FormatError::TooLarge { needed_bytes, limit_bytes });
        }
        Ok(())
    }

    /// Returns the memory of this file and of another that is read after it.
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        Self {
            held_bytes: self.held_bytes + next.held_bytes,
            peak_bytes: self.peak_bytes.max(self.held_bytes + next.peak_bytes),
            writing_bytes: (self.writing_bytes + next.held_bytes).max(self.held_bytes + next.writing_bytes),
        }
    }
}

impl ShadowFile {
    /// Returns the memory that the file at `path` takes. Only the beginning of the file is read: header,
    /// directory and tables.
    ///
    /// # Errors
    /// Returns [`Error::Io`] if the operating system fails to read the file, and [`Error::Format`] if these
    /// bytes are not valid.
    #[doc(hidden)]
    pub fn memory(path: impl AsRef<Path>) -> Result<FileMemory> {
        let path = path.as_ref();
        let mut file = File::open(path).map_err(IoError::at("read", path))?;
        let mut first = |end| {
            let mut bytes = Vec::new();
            file.rewind()?;
            (&mut file).take(end).read_to_end(&mut bytes)?;
            Ok(bytes)
        };
        FileMemory::of(
            |end| first(end).map_err(|error| IoError::at("read", path)(error).into()),
            |fault| Error::in_file(path, fault),
        )
    }
}

/// Returns the bytes that a level holds once it is read.
fn held_bytes(grid: &GridEntry, table: &[BundleEntry]) -> u64 {
    let size = grid.grid.size;
    let count = |dims: [u32; 2]| dims.map(u64::from).iter().product::<u64>();
    let pages = table.iter().map(page_bytes).sum::<u64>();
    let blocks = count(top::block_dims(size, top::block_level(size)));
    common_bytes(grid) + pages + PLACED_PAGE_BYTES * count(page::page_dims(size)) + 8 * blocks
}

/// Returns the bytes that a level takes while it is read, in addition to the bytes held.
fn decoding_bytes(grid: &GridEntry, table: &[BundleEntry]) -> u64 {
    let batches = table.chunks(BATCH_BUNDLES).map(|batch| batch.iter().map(page_bytes).sum::<u64>());
    let words = common_bytes(grid) + batches.max().unwrap_or_default();
    words + DECODING_RATIO * shapes_bytes(grid, table)
}

/// Returns the bytes of the words whose shapes are in lists at one time, while they are coded or decoded: the
/// common section, and one bundle per thread.
fn shapes_bytes(grid: &GridEntry, table: &[BundleEntry]) -> u64 {
    let largest = table.iter().map(page_bytes).max().unwrap_or_default();
    let all = table.iter().map(page_bytes).sum();
    common_bytes(grid) + (threads() as u64 * largest).min(all)
}

fn common_bytes(grid: &GridEntry) -> u64 {
    grid.common_raw_bytes.min(MOST_BYTES)
}

/// Returns the bytes of the words of a bundle's pages.
fn page_bytes(entry: &BundleEntry) -> u64 {
    u64::from(entry.raw_bytes).saturating_sub(4 * HEAD_WORDS as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forged_lengths_give_huge_memory_without_overflow() {
        let bytes = std::fs::read(adumbra_testing::vectors("valid/many_pages_depths.adumbra")).unwrap();
        let contents = Contents::parse(&bytes).unwrap();
        let true_bytes = FileMemory::of_contents(&contents).peak_bytes;
        let forge: [fn(&mut Contents); 2] =
            [|c| c.header.file_bytes = u64::MAX, |c| c.grids[0].common_raw_bytes = u64::MAX];
        for forge in forge {
            let mut forged = contents.clone();
            forge(&mut forged);
            let found = FileMemory::of_contents(&forged);
            assert!(found.peak_bytes >= MOST_BYTES && true_bytes < 1 << 30, "{found:?}");
        }
    }
}
