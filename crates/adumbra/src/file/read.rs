//! Decoding of a [`ShadowFile`]. Nothing is allocated until the file's length has been found to justify it.

use std::path::Path;

use crate::error::{Error, FormatError, IoError, Result};
use crate::file::contents::name_of_bundle;
use crate::file::directory::GridEntry;
use crate::file::fields::field;
use crate::file::header::Header;
use crate::file::memory::BATCH_BUNDLES;
use crate::file::sections::read_file;
use crate::file::table::{Bundle, BundleEntry};
use crate::file::{Contents, FileMemory, HEADER_BYTES, ShadowFile, each};
use crate::layout::depths::page::{HEAD_WORDS, bundles, page_dims};
use crate::layout::depths::{DepthTree, Ranges, TreeBuilder};
use crate::settings::Encoding;

impl ShadowFile {
    /// Reads and validates the file at `path`.
    ///
    /// The header is read first, so a large file of another kind is refused without being read.
    ///
    /// # Errors
    /// Returns [`Error::Io`] if the operating system fails to read the file, and [`Error::Format`] if the
    /// file is not valid.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let bytes = read_file(path, HEADER_BYTES, |front| Ok(Header::parse(front)?.file_bytes))?;
        Self::from_bytes(&bytes).map_err(|fault| Error::in_file(path, fault))
    }

    /// Reads and validates the file at `path` if that takes at most `limit_bytes` of memory, the file's own
    /// bytes with it.
    ///
    /// For files from others: a file of a few megabytes is often five times as large in memory, and a forged
    /// one can be 300 times as large. Header, directory and tables say how large it can be, so one that may
    /// be too large is refused before the rest is read. A pipe cannot be read this way.
    ///
    /// # Errors
    /// Returns the errors of [`ShadowFile::read`], and [`Error::Format`] with [`FormatError::TooLarge`].
    pub fn read_within(path: impl AsRef<Path>, limit_bytes: u64) -> Result<Self> {
        let path = path.as_ref();
        let too_large =
            |needed_bytes| Error::in_file(path, FormatError::TooLarge { needed_bytes, limit_bytes });
        let length = std::fs::metadata(path).map_err(IoError::at("read", path))?.len();
        if length > limit_bytes {
            return Err(too_large(length));
        }
        let needed_bytes = Self::memory(path)?.peak_bytes;
        if needed_bytes > limit_bytes {
            return Err(too_large(needed_bytes));
        }
        // The file may have been replaced since.
        let bytes = read_file(path, HEADER_BYTES, |front| Ok(Header::parse(front)?.file_bytes))?;
        Self::from_bytes_within(&bytes, limit_bytes).map_err(|fault| Error::in_file(path, fault))
    }

    /// Decodes and validates a whole file.
    ///
    /// Cost: time linear in the decoded words; memory for them once, and for the file's bytes. Besides, 64
    /// bundles are decoded at a time.
    ///
    /// # Errors
    /// Returns the fault with the values found. All bytes that are not exactly one valid file are refused.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_bytes_within(bytes, u64::MAX)
    }

    /// Decodes and validates a whole file if that takes at most `limit_bytes` of memory, as
    /// [`ShadowFile::read_within`] does.
    ///
    /// # Errors
    /// Returns the errors of [`ShadowFile::from_bytes`], and [`FormatError::TooLarge`].
    pub fn from_bytes_within(bytes: &[u8], limit_bytes: u64) -> Result<Self, FormatError> {
        let contents = Contents::parse(bytes)?;
        FileMemory::check(&contents, limit_bytes)?;
        let encoding = contents.header.encoding;
        let mut levels = Vec::with_capacity(contents.grids.len());
        for (level, (grid, table)) in (0..).zip(contents.grids.iter().zip(&contents.tables)) {
            levels.push((grid.grid, read_tree(bytes, encoding, level, grid, table)?));
        }
        let mut levels = levels.into_iter();
        let Some((grid, tree)) = levels.next() else {
            return Err(field("grids", "0", "at least 1"));
        };
        Ok(Self::new(grid, contents.header.settings, tree).with_coarser(levels))
    }
}

/// Decodes the tree of one grid. The file has all bytes that its directory and tables name.
fn read_tree(
    bytes: &[u8],
    encoding: Encoding,
    level: u32,
    grid: &GridEntry,
    table: &[BundleEntry],
) -> Result<DepthTree, FormatError> {
    let common = &bytes[grid.common.offset as usize..grid.common.end() as usize];
    let common = grid.parse_common(common, encoding, level)?;
    let size = grid.grid.size;
    let (dims, places) = (page_dims(size), bundles(page_dims(size)));
    let mut builder = TreeBuilder::new(size, common.words().to_vec());
    let pages_bytes = |entry: &BundleEntry| (entry.raw_bytes as usize).saturating_sub(4 * HEAD_WORDS);
    builder.reserve(table.iter().map(pages_bytes).sum::<usize>() / 4);
    let mut at = grid.bundles.offset as usize;
    let stored: Vec<(usize, &BundleEntry, &[u8])> = (0..)
        .zip(table)
        .map(|(i, entry)| {
            let bytes = &bytes[at..][..entry.stored_bytes as usize];
            at += bytes.len();
            (i, entry, bytes)
        })
        .collect();
    let parse = |&(i, entry, bytes): &(usize, &BundleEntry, &[u8])| {
        let name = || name_of_bundle(level, i);
        let bundle = Bundle::parse(entry, bytes, &common, name)?;
        bundle.check_pages(entry, (places[i], dims), name)?;
        Ok(bundle)
    };
    for batch in stored.chunks(BATCH_BUNDLES) {
        // Return the error of the first bundle that fails.
        for (&(i, ..), bundle) in batch.iter().zip(each(batch, parse)) {
            builder.add(places[i], &bundle?.pages());
        }
    }
    // Free the lists of shapes: they are as large as the memory that checking needs.
    drop(common);
    let tree = builder.finish().map_err(|fault| FormatError::Depths { level, fault })?;
    let mut ranges = Ranges::new(tree.common());
    for (i, (entry, &place)) in table.iter().zip(&places).enumerate() {
        entry.check_range(&tree.bundle(place), (place, dims), &mut ranges, || name_of_bundle(level, i))?;
    }
    Ok(tree)
}
