//! Encoding of a [`ShadowFile`].

use std::io::{self, Cursor, ErrorKind, Seek, SeekFrom, Write};

use crate::error::FormatError;
use crate::file::common::CommonSection;
use crate::file::directory::{GridEntry, check_grids, place, table_bytes};
use crate::file::fields::field;
use crate::file::header::{Header, directory_bytes};
use crate::file::sections::Section;
use crate::file::table::{StoredBundle, raw_bytes};
use crate::file::{HEADER_BYTES, Level, ShadowFile, each};
use crate::grid::LightGrid;
use crate::layout::depths::page::{BUNDLES_AT_A_TIME, bundles, page_dims};
use crate::layout::depths::{DepthTree, SharedRanges};
use crate::settings::{Encoding, FileSettings};

impl ShadowFile {
    /// Writes the bytes of the file to `out`, from its position on. Returns their number.
    ///
    /// # Errors
    /// Returns the errors of `out`, and [`ErrorKind::InvalidData`] with a [`FormatError`] if the contents are
    /// not valid, or if they are to be coded and cannot be.
    pub fn write_to(&self, out: impl Write + Seek, encoding: Encoding) -> io::Result<u64> {
        let levels = self.levels();
        let grids: Vec<LightGrid> = levels.iter().map(|level| level.grid).collect();
        let mut writer = FileWriter::new(out, self.settings, &grids, encoding)?;
        for level in levels.iter().rev() {
            let tree = &*level.tree;
            if tree.size() != level.grid.size {
                let expected = format!("the quadtree's {:?}", tree.size());
                return Err(invalid(field("size", format!("{:?}", level.grid.size), expected)));
            }
            writer.write_level(tree)?;
        }
        writer.finish()
    }
}

impl ShadowFile {
    /// Returns the bytes of the file.
    ///
    /// # Errors
    /// Returns the fault if the contents are not valid, or if they are to be coded and cannot be.
    pub fn to_bytes(&self, encoding: Encoding) -> Result<Vec<u8>, FormatError> {
        let capacity = if encoding == Encoding::Raw { self.encoded_len() } else { 0 };
        let mut bytes = Cursor::new(Vec::with_capacity(capacity as usize));
        match self.write_to(&mut bytes, encoding) {
            Ok(_) => Ok(bytes.into_inner()),
            // Writing to memory gives no I/O errors.
            Err(error) => Err(error.downcast().unwrap_or(FormatError::TrailingBytes { end: 0 })),
        }
    }

    /// Returns the size in bytes of the raw file. Cost: a pass over the pages.
    pub fn encoded_len(&self) -> u64 {
        let levels = self.levels();
        let front = HEADER_BYTES + directory_bytes(levels.len() as u32);
        levels.iter().fold(front as u64, |sum, Level { tree, .. }| {
            let dims = tree.page_dims();
            let bundles = bundles(dims).into_iter().map(|at| raw_bytes(at, dims, &tree.bundle(at)));
            sum + table_bytes(tree.size()) + 4 * tree.common().len() as u64 + bundles.sum::<u64>()
        })
    }
}

/// Writes a file part by part: for each grid, the coarsest first, its common section and then its bundles in
/// order.
pub struct FileWriter<W> {
    out: W,
    /// Position of the file's first byte.
    start: u64,
    settings: FileSettings,
    encoding: Encoding,
    grids: Vec<GridEntry>,
    /// The tables of grids whose bundles have been added.
    tables: Vec<Vec<u8>>,
    /// Number of grids whose common section has not been written.
    left: usize,
}

fn invalid(fault: FormatError) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, fault)
}

impl<W: Write + Seek> FileWriter<W> {
    /// Begins a file with these grids, the finest first.
    ///
    /// # Errors
    /// Returns the errors of `out`, and [`ErrorKind::InvalidData`] with a [`FormatError`] if settings or
    /// grids are not valid. Nothing has been written then.
    pub fn new(
        mut out: W,
        settings: FileSettings,
        grids: &[LightGrid],
        encoding: Encoding,
    ) -> io::Result<Self> {
        let none = Section::default();
        let entry = |&grid| GridEntry { grid, table: none, common: none, common_raw_bytes: 0, bundles: none };
        let grids: Vec<GridEntry> = grids.iter().map(entry).collect();
        let count = grids.len() as u32;
        let header = Header { settings, encoding, grids: count, directory_checksum: 0, file_bytes: 0 };
        header.check().and_then(|()| check_grids(&grids)).map_err(invalid)?;
        let start = out.stream_position()?;
        let tables: u64 = grids.iter().map(|entry| table_bytes(entry.grid.size)).sum();
        let front = (HEADER_BYTES + directory_bytes(count)) as u64 + tables;
        io::copy(&mut io::Read::take(io::repeat(0), front), &mut out)?;
        let left = grids.len();
        Ok(Self { out, start, settings, encoding, tables: vec![Vec::new(); left], grids, left })
    }

    /// Writes the common section of the next grid, the coarsest first.
    ///
    /// # Errors
    /// Returns the errors of the output, and [`ErrorKind::InvalidData`] with [`FormatError::Uncodable`].
    pub fn common(&mut self, common: &CommonSection) -> io::Result<()> {
        debug_assert_eq!(common.encoding(), self.encoding);
        let bytes = common.to_bytes().map_err(invalid)?;
        self.out.write_all(&bytes)?;
        self.left -= 1;
        let grid = &mut self.grids[self.left];
        grid.common = Section { offset: 0, length: bytes.len() as u64, checksum: crc32fast::hash(&bytes) };
        grid.common_raw_bytes = 4 * common.words().len() as u64;
        Ok(())
    }

    /// Writes the next bundle of the grid whose common section was written last.
    ///
    /// # Errors
    /// Returns the errors of the output.
    pub fn bundle(&mut self, bundle: &StoredBundle) -> io::Result<()> {
        self.out.write_all(&bundle.bytes)?;
        self.grids[self.left].bundles.length += bundle.bytes.len() as u64;
        self.tables[self.left].extend(bundle.entry.encode());
        Ok(())
    }

    fn write_level(&mut self, tree: &DepthTree) -> io::Result<()> {
        let words = tree.common().to_vec();
        let common = CommonSection::new(words, || tree.common_shapes(), self.encoding).map_err(invalid)?;
        self.common(&common)?;
        let dims = page_dims(tree.size());
        let ranges = SharedRanges::new(common.words());
        let stored = |&at: &[u32; 2]| {
            ranges.with(|ranges| StoredBundle::new(at, dims, &tree.bundle(at), ranges, &common))
        };
        for some in bundles(dims).chunks(BUNDLES_AT_A_TIME) {
            each(some, stored).into_iter().try_for_each(|stored| self.bundle(&stored.map_err(invalid)?))?;
        }
        Ok(())
    }

    /// Writes tables, directory and header, and returns the number of bytes of the file. Every bundle of
    /// every grid must have been written.
    ///
    /// # Errors
    /// Returns the errors of the output.
    pub fn finish(mut self) -> io::Result<u64> {
        let file_bytes = place(&mut self.grids);
        for (entry, table) in self.grids.iter_mut().zip(&self.tables) {
            debug_assert_eq!(entry.table.length, table.len() as u64);
            entry.table.checksum = crc32fast::hash(table);
        }
        let directory: Vec<u8> =
            (0..).zip(&self.grids).flat_map(|(level, entry)| entry.encode(level)).collect();
        let header = Header {
            settings: self.settings,
            encoding: self.encoding,
            grids: self.grids.len() as u32,
            directory_checksum: crc32fast::hash(&directory),
            file_bytes,
        };
        self.out.seek(SeekFrom::Start(self.start))?;
        self.out.write_all(&header.encode())?;
        self.out.write_all(&directory)?;
        for table in &self.tables {
            self.out.write_all(table)?;
        }
        self.out.seek(SeekFrom::Start(self.start + file_bytes))?;
        self.out.flush()?;
        Ok(file_bytes)
    }
}
