//! Decoding of a [`ShadowFile`]. Nothing is allocated until the file's length has been found to justify it.

use std::path::Path;

use crate::error::FormatError;
use crate::error::{Error, Result};
use crate::file::common::CommonSection;
use crate::file::directory::{self, GridEntry};
use crate::file::fields::field;
use crate::file::header::{Header, directory_bytes};
use crate::file::sections::{Section, read_file};
use crate::file::table::{BUNDLE_ENTRY_BYTES, Bundle, BundleEntry};
use crate::file::{Contents, HEADER_BYTES, ShadowFile, each};
use crate::layout::depths::page::{bundles, page_dims};
use crate::layout::depths::{DepthTree, Ranges, TreeBuilder};
use crate::settings::AtRest;

impl ShadowFile {
    /// Reads and validates the file at `path`.
    ///
    /// The header is read first, so a large file of another kind is refused without being read.
    ///
    /// # Errors
    /// Returns [`Error::Io`] if the operating system fails to read the file, and [`Error::Format`] if the file is not
    /// valid.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let bytes = read_file(path, HEADER_BYTES, |front| Ok(Header::parse(front)?.file_bytes))?;
        Self::from_bytes(&bytes)
            .map_err(|source| Error::Format { path: path.to_owned(), source: Box::new(source) })
    }

    /// Decodes and validates a whole file.
    ///
    /// Cost: time linear in the decoded words; memory for them once, and for the file's bytes. Besides, 64 bundles are
    /// decoded at a time.
    ///
    /// # Errors
    /// Returns the fault with the values found. All bytes that are not exactly one valid file are refused.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let contents = Contents::parse(bytes)?;
        let levels = (0..).zip(&contents.grids).map(|(level, grid)| {
            let part = Part { bytes, at_rest: contents.header.at_rest, level };
            Ok((grid.grid, part.tree(grid, &contents.tables[level as usize])?))
        });
        let mut levels = levels.collect::<Result<Vec<_>, FormatError>>()?.into_iter();
        let Some((grid, tree)) = levels.next() else {
            return Err(field("grids", "0", "at least 1"));
        };
        Ok(Self::new(grid, contents.header.settings, tree).with_coarser(levels))
    }
}

impl Contents {
    /// Reads and checks header, directory and tables of a whole file.
    ///
    /// # Errors
    /// Returns the fault with the values found.
    pub fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let (header, grids) = header_and_directory(bytes)?;
        let (have, end) = (bytes.len() as u64, header.file_bytes);
        let parts = (0..).zip(&grids).flat_map(|(level, grid): (u32, _)| {
            let names = ["table", "common section", "bundles"].map(|what| format!("{what} of level {level}"));
            [grid.table, grid.common, grid.bundles].into_iter().zip(names)
        });
        let cut = parts.filter(|(part, _)| part.end() > have).min_by_key(|(part, _)| part.offset);
        if let Some((part, name)) = cut {
            return Err(FormatError::Truncated { what: name.into(), needed: part.end(), have });
        }
        if have > end {
            return Err(FormatError::TrailingBytes { end });
        }
        Self::with_tables(bytes, header, grids)
    }

    /// Reads and checks header, directory and tables of the beginning of a file.
    ///
    /// # Errors
    /// Returns the fault with the values found.
    pub fn parse_beginning(bytes: &[u8]) -> Result<Self, FormatError> {
        let (header, grids) = header_and_directory(bytes)?;
        Self::with_tables(bytes, header, grids)
    }

    fn with_tables(bytes: &[u8], header: Header, grids: Vec<GridEntry>) -> Result<Self, FormatError> {
        let part = |level| Part { bytes, at_rest: header.at_rest, level };
        let tables = (0..).zip(&grids).map(|(level, grid)| part(level).table(grid));
        let tables = tables.collect::<Result<_, _>>()?;
        Ok(Self { header, grids, tables })
    }
}

/// Returns the offset at which the directory ends. `front` has the header.
///
/// # Errors
/// Returns the fault with the values found.
pub(super) fn directory_end(front: &[u8]) -> Result<u64, FormatError> {
    let grids = Header::parse(front)?.grids;
    Ok((HEADER_BYTES + directory_bytes(grids)) as u64)
}

/// Returns the offset at which the tables end. `front` has header and directory.
///
/// # Errors
/// Returns the fault with the values found.
pub(super) fn tables_end(front: &[u8]) -> Result<u64, FormatError> {
    let (_, grids) = header_and_directory(front)?;
    Ok(grids.iter().map(|grid| grid.table.end()).max().unwrap_or_default())
}

/// Returns the length in bytes of the beginning of a file up to the end of its coarsest level. `front` is the beginning
/// of the beginning, with header and directory.
///
/// # Errors
/// Returns the fault with the values found.
pub fn beginning_bytes(front: &[u8]) -> Result<u64, FormatError> {
    let (header, grids) = header_and_directory(front)?;
    Ok(grids.last().map_or(header.file_bytes, |coarsest| coarsest.bundles.end()))
}

fn header_and_directory(bytes: &[u8]) -> Result<(Header, Vec<GridEntry>), FormatError> {
    let header = Header::parse(bytes)?;
    let directory = Section {
        offset: HEADER_BYTES as u64,
        length: directory_bytes(header.grids) as u64,
        checksum: header.directory_checksum,
    };
    let directory = checked(bytes, directory, || "directory".to_owned())?;
    let grids = directory::parse(directory, header.file_bytes, header.at_rest)?;
    Ok((header, grids))
}

impl GridEntry {
    /// Reads the stored bytes of the grid's common section. `level` names it.
    ///
    /// # Errors
    /// Returns the fault with the values found.
    pub fn parse_common(
        &self,
        bytes: &[u8],
        at_rest: AtRest,
        level: u32,
    ) -> Result<CommonSection, FormatError> {
        let name = || format!("common section of level {level}");
        let whole = Section { offset: 0, ..self.common };
        CommonSection::parse(checked(bytes, whole, name)?, self.common_raw_bytes, at_rest, name)
    }
}

/// Returns the name of a bundle in messages.
pub fn name_of_bundle(level: u32, index: usize) -> String {
    format!("bundle {index} of level {level}")
}

/// Returns the bytes of a section, after comparing them with its checksum.
fn checked(bytes: &[u8], section: Section, name: impl Fn() -> String) -> Result<&[u8], FormatError> {
    let found = usize::try_from(section.end()).ok().and_then(|end| bytes.get(section.offset as usize..end));
    let Some(found) = found else {
        let (needed, have) = (section.end(), bytes.len() as u64);
        return Err(FormatError::Truncated { what: name().into(), needed, have });
    };
    let (stored, computed) = (section.checksum, crc32fast::hash(found));
    if stored == computed {
        return Ok(found);
    }
    Err(FormatError::SectionChecksum { section: name().into(), stored, computed })
}

/// Number of bundles that are decoded at a time. Their words are in memory twice until they are in the tree.
pub(super) const BATCH_BUNDLES: usize = 64;

/// The parts of one grid in a file whose directory fits its length.
struct Part<'b> {
    bytes: &'b [u8],
    at_rest: AtRest,
    level: u32,
}

impl Part<'_> {
    fn name_of_bundle(&self, index: usize) -> String {
        name_of_bundle(self.level, index)
    }

    /// Reads the table, and checks that its bundles are as long as all bundles together.
    fn table(&self, grid: &GridEntry) -> Result<Vec<BundleEntry>, FormatError> {
        let level = self.level;
        let bytes = checked(self.bytes, grid.table, || format!("table of level {level}"))?;
        let entries = bytes.chunks_exact(BUNDLE_ENTRY_BYTES).enumerate();
        let entries: Vec<BundleEntry> = entries
            .map(|(i, bytes)| BundleEntry::parse(bytes, self.at_rest, || self.name_of_bundle(i)))
            .collect::<Result<_, _>>()?;
        let sum: u64 = entries.iter().map(|entry| u64::from(entry.stored_bytes)).sum();
        if sum != grid.bundles.length {
            let section = format!("table of level {level}");
            let found = format!("bundles of {sum} bytes in all");
            return Err(FormatError::Bundle {
                section,
                found,
                expected: "the directory's length of all bundles",
            });
        }
        Ok(entries)
    }

    fn tree(&self, grid: &GridEntry, table: &[BundleEntry]) -> Result<DepthTree, FormatError> {
        let level = self.level;
        let name = || format!("common section of level {level}");
        let common = checked(self.bytes, grid.common, name)?;
        let common = CommonSection::parse(common, grid.common_raw_bytes, self.at_rest, name)?;
        let size = grid.grid.size;
        let (dims, places) = (page_dims(size), bundles(page_dims(size)));
        let mut builder = TreeBuilder::new(size, common.words().to_vec());
        let mut at = grid.bundles.offset as usize;
        let stored: Vec<(usize, &BundleEntry, &[u8])> = (0..)
            .zip(table)
            .map(|(i, entry)| {
                let bytes = &self.bytes[at..][..entry.stored_bytes as usize];
                at += bytes.len();
                (i, entry, bytes)
            })
            .collect();
        let parse = |&(i, entry, bytes): &(usize, &BundleEntry, &[u8])| {
            let name = || self.name_of_bundle(i);
            let bundle = Bundle::parse(entry, bytes, &common, name)?;
            bundle.check_pages(entry, (places[i], dims), name)?;
            Ok(bundle)
        };
        for batch in stored.chunks(BATCH_BUNDLES) {
            // The error is that of the first bundle that has one.
            for (&(i, ..), bundle) in batch.iter().zip(each(batch, parse)) {
                builder.add(places[i], &bundle?.pages());
            }
        }
        let tree = builder.finish().map_err(|fault| FormatError::Depths { level, fault })?;
        let mut ranges = Ranges::new(common.words());
        for (i, (entry, &place)) in table.iter().zip(&places).enumerate() {
            entry.check_range(&tree.bundle(place), (place, dims), &mut ranges, || self.name_of_bundle(i))?;
        }
        Ok(tree)
    }
}
