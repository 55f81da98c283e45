//! The directory: an entry of 256 bytes per grid, and where the grid's parts are in the file.
//!
//! The tables of all grids follow the directory, finest grid first. Then come common section and bundles of
//! each grid, coarsest grid first, so that a reader that has the beginning of a file can already answer.

use crate::coder::LARGEST_RATIO;
use crate::error::FormatError;
use crate::file::common::is_plausible;
use crate::file::fields::{Decoder, Encoder, field, reserved, sun};
use crate::file::header::{GRID_BYTES, HEADER_BYTES, directory_bytes};
use crate::file::placement::{check_grid, frame, frame_fields};
use crate::file::sections::{Section, bounds};
use crate::file::table::BUNDLE_ENTRY_BYTES;
use crate::grid::LightGrid;
use crate::layout::depths::page::{bundle_count, page_dims};
use crate::settings::Encoding;

/// A level has voxels this many times as large as those of the level before it.
pub const LEVEL_STEP: u32 = 4;

/// A directory entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridEntry {
    /// Placement of the voxels in the world.
    pub grid: LightGrid,
    /// The page table.
    pub table: Section,
    /// The common section.
    pub common: Section,
    /// Length of the common section's words in bytes.
    pub common_raw_bytes: u64,
    /// The bundles, one after the other. The checksum of each is in the table.
    pub bundles: Section,
}

impl GridEntry {
    /// Encodes the entry.
    pub(super) fn encode(&self, level: u32) -> [u8; GRID_BYTES] {
        let grid = &self.grid;
        let mut out = Encoder::<GRID_BYTES>::blank();
        out.u32s(&grid.size);
        out.u32s(&[level]);
        out.f64s(&[grid.voxel_size]);
        out.f64s(&grid.sun.towards());
        out.f64s(&grid.corner);
        out.f64s(grid.axes.as_flattened());
        let (frame, yaw_radians) = frame_fields(grid.frame);
        out.u32s(&[frame, 0]);
        out.f64s(&[yaw_radians]);
        out.sections(&[self.table, self.common, self.bundles]);
        out.u64s(&[self.common_raw_bytes]);
        out.bytes()
    }

    fn parse(bytes: &[u8], level: u32) -> Result<Self, FormatError> {
        let mut fields = Decoder { bytes };
        let size = fields.u32s()?;
        let found_level = fields.u32()?;
        let voxel_size = fields.f64()?;
        let towards = fields.f64s()?;
        let corner = fields.f64s()?;
        let axes = [fields.f64s()?, fields.f64s()?, fields.f64s()?];
        let frame_number = fields.u32()?;
        reserved("reserved word of a grid", fields.u32()?)?;
        let [yaw_radians] = fields.f64s()?;
        let [table, common, bundles] = fields.sections()?;
        let common_raw_bytes = fields.u64()?;
        fields.end("reserved words of a grid")?;
        if found_level != level {
            return Err(field("level", found_level.to_string(), level.to_string()));
        }
        reserved("checksum of all bundles", bundles.checksum)?;
        let sun = sun(towards)?;
        let frame = frame(frame_number, yaw_radians)?;
        let edges = frame.edges(&sun, &axes);
        let grid = LightGrid { sun, frame, voxel_size, corner, axes, edges, size };
        Ok(Self { grid, table, common, common_raw_bytes, bundles })
    }
}

/// Reads and checks a directory. `file_bytes` and `encoding` are the header's.
pub(super) fn parse(
    bytes: &[u8],
    file_bytes: u64,
    encoding: Encoding,
) -> Result<Vec<GridEntry>, FormatError> {
    let entries = (0..).zip(bytes.chunks_exact(GRID_BYTES)).map(|(level, b)| GridEntry::parse(b, level));
    let entries: Vec<GridEntry> = entries.collect::<Result<_, _>>()?;
    check_grids(&entries)?;
    check_places(&entries, file_bytes, encoding)?;
    Ok(entries)
}

/// Checks the placement of all grids.
pub(super) fn check_grids(entries: &[GridEntry]) -> Result<(), FormatError> {
    let mut expected_voxel = None;
    for entry in entries {
        let grid = &entry.grid;
        check_grid(grid)?;
        let first = &entries[0].grid;
        if grid.sun != first.sun || grid.frame != first.frame {
            return Err(field("sun", format!("{:?}, {:?}", grid.sun, grid.frame), "that of the first grid"));
        }
        let voxel = expected_voxel.unwrap_or(grid.voxel_size);
        if grid.voxel_size != voxel {
            return Err(field("voxel_size", grid.voxel_size.to_string(), voxel.to_string()));
        }
        expected_voxel = Some(voxel * f64::from(LEVEL_STEP));
    }
    Ok(())
}

/// Returns the length of a grid's table in bytes.
pub(super) fn table_bytes(size: [u32; 3]) -> u64 {
    bundle_count(page_dims(size)) * BUNDLE_ENTRY_BYTES as u64
}

/// Sets all offsets from the lengths of common sections and bundles. Returns the length of the file.
pub(super) fn place(entries: &mut [GridEntry]) -> u64 {
    let mut end = HEADER_BYTES as u64 + directory_bytes(entries.len() as u32) as u64;
    let mut put = |section: &mut Section| {
        section.offset = end;
        end = section.end();
    };
    for entry in entries.iter_mut() {
        entry.table.length = table_bytes(entry.grid.size);
        put(&mut entry.table);
    }
    for entry in entries.iter_mut().rev() {
        put(&mut entry.common);
        put(&mut entry.bundles);
    }
    end
}

/// Checks that every part begins where the parts before it end, that common sections can be as long as the
/// directory says once they are decoded, and that the file ends with the last part.
fn check_places(entries: &[GridEntry], file_bytes: u64, encoding: Encoding) -> Result<(), FormatError> {
    let mut expected = entries.to_vec();
    let end = place(&mut expected);
    for (level, (found, expected)) in entries.iter().zip(&expected).enumerate() {
        let parts = [
            ("table", found.table, expected.table),
            ("common section", found.common, expected.common),
            ("bundles", found.bundles, expected.bundles),
        ];
        for (what, found, expected) in parts {
            let fields =
                [("offset", found.offset, expected.offset), ("length", found.length, expected.length)];
            if let Some((name, value, expected)) = fields.into_iter().find(|(_, a, b)| a != b) {
                return Err(bounds(format!("{what} of level {level}"), name, value, expected.to_string()));
            }
        }
        if let Some(expected) = required_raw_bytes(found, encoding) {
            let section = format!("common section of level {level}");
            return Err(bounds(section, "raw length", found.common_raw_bytes, expected));
        }
    }
    if end != file_bytes {
        return Err(field("file_bytes", file_bytes.to_string(), end.to_string()));
    }
    Ok(())
}

/// Returns the raw length that a common section must have, as text, if it has another.
fn required_raw_bytes(entry: &GridEntry, encoding: Encoding) -> Option<String> {
    let GridEntry { common: Section { length, .. }, common_raw_bytes, .. } = *entry;
    match encoding {
        Encoding::Raw => (common_raw_bytes != length).then(|| length.to_string()),
        Encoding::Coded => {
            let fits = is_plausible(length, common_raw_bytes) && (length == 0) == (common_raw_bytes == 0);
            (!fits).then(|| format!("whole words, and at most {LARGEST_RATIO} times its length"))
        }
    }
}
