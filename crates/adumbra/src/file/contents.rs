//! The description of a file's parts: header, directory and tables.

use crate::error::FormatError;
use crate::file::common::{CommonSection, fault};
use crate::file::directory::{self, GridEntry};
use crate::file::header::{Header, directory_bytes};
use crate::file::sections::{Section, checked};
use crate::file::table::{BUNDLE_ENTRY_BYTES, BundleEntry};
use crate::file::{Contents, HEADER_BYTES};
use crate::settings::Encoding;

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
        let tables = (0..).zip(&grids).map(|(level, grid)| table(bytes, header.encoding, level, grid));
        let tables = tables.collect::<Result<_, _>>()?;
        Ok(Self { header, grids, tables })
    }
}

/// Returns the offset at which the tables end. `front` has header and directory.
///
/// # Errors
/// Returns the fault with the values found.
pub(super) fn tables_end(front: &[u8]) -> Result<u64, FormatError> {
    let (_, grids) = header_and_directory(front)?;
    Ok(grids.iter().map(|grid| grid.table.end()).max().unwrap_or_default())
}

/// Returns the length in bytes of the beginning of a file up to the end of its coarsest level. `front` is a
/// prefix of the file that includes header and directory.
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
    let grids = directory::parse(directory, header.file_bytes, header.encoding)?;
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
        encoding: Encoding,
        level: u32,
    ) -> Result<CommonSection, FormatError> {
        let name = || format!("common section of level {level}");
        let whole = Section { offset: 0, ..self.common };
        CommonSection::parse(checked(bytes, whole, name)?, self.common_raw_bytes, encoding, name)
    }
}

/// Returns the name of a bundle in messages.
pub fn name_of_bundle(level: u32, index: usize) -> String {
    format!("bundle {index} of level {level}")
}

/// Reads the table of a level, and checks that its bundles are as long as all bundles together.
fn table(
    bytes: &[u8],
    encoding: Encoding,
    level: u32,
    grid: &GridEntry,
) -> Result<Vec<BundleEntry>, FormatError> {
    let name = || format!("table of level {level}");
    let bytes = checked(bytes, grid.table, name)?;
    let entries = bytes.chunks_exact(BUNDLE_ENTRY_BYTES).enumerate();
    let entries: Vec<BundleEntry> = entries
        .map(|(i, bytes)| BundleEntry::parse(bytes, encoding, || name_of_bundle(level, i)))
        .collect::<Result<_, _>>()?;
    let sum: u64 = entries.iter().map(|entry| u64::from(entry.stored_bytes)).sum();
    if sum != grid.bundles.length {
        let found = format!("bundles of {sum} bytes in all");
        return Err(fault(name, found, "the directory's length of all bundles"));
    }
    Ok(entries)
}
