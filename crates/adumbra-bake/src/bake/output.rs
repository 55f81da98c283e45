//! Writes the levels of a file, and files that replace others when they are complete.

use std::fs::File;
use std::io::{self, ErrorKind, Seek, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use adumbra::file::{CommonSection, FileWriter, LEVEL_STEP, StoredBundle};
use adumbra::layout::depths::SharedRanges;
use adumbra::layout::depths::page::{BUNDLE_PAGES, Page, page_dims};
use adumbra::{Encoding, FileSettings, FormatError, LightGrid, Region};
use adumbra_files::StagedFile;

use super::BakeSummary;
use crate::error::{Error, Result};
use crate::pages::Pages;

/// Calls `write` to fill a temporary file, which replaces the one at `path` when it is placed.
///
/// # Errors
/// Returns the errors of `write`, and [`Error::Io`] if the file cannot be written. No temporary file is left
/// then.
pub(crate) fn stage(
    path: &Path,
    write: impl FnOnce(&mut File) -> Result<BakeSummary>,
) -> Result<(StagedFile, BakeSummary)> {
    let mut outcome = None;
    let staged = StagedFile::new(path, |out| match write(out) {
        Ok(summary) => {
            let bytes = summary.bytes;
            outcome = Some(Ok(summary));
            Ok(bytes)
        }
        Err(Error::Output(error)) => Err(error),
        Err(error) => {
            outcome = Some(Err(error));
            Err(io::Error::other("the file was not finished"))
        }
    });
    match (staged, outcome) {
        (Ok(staged), Some(Ok(summary))) => Ok((staged, summary)),
        // The error that stopped the work says more than that the file is incomplete.
        (_, Some(Err(error))) => Err(error),
        (Err(error), _) => Err(error.into()),
        (Ok(_), None) => unreachable!("a staged file has been written"),
    }
}

/// Returns a level's grid as the file has it: that of a region is relative to the region's origin.
pub(crate) fn stored_grid(grid: LightGrid, region: Option<Region>, level: usize) -> LightGrid {
    region.map_or(grid, |region| region.relative(grid, LEVEL_STEP.pow(level as u32)))
}

/// Begins a file with grids that lie in the world, the finest first.
pub(crate) fn file_writer<W: Write + Seek>(
    out: W,
    settings: FileSettings,
    grids: &[LightGrid],
    encoding: Encoding,
) -> Result<FileWriter<W>> {
    let stored = |(level, grid): (usize, &LightGrid)| stored_grid(*grid, settings.region, level);
    let stored: Vec<LightGrid> = grids.iter().enumerate().map(stored).collect();
    FileWriter::new(out, settings, &stored, encoding).map_err(Error::Output)
}

/// Links the pages of a level, and writes them.
pub(crate) fn write_level(
    writer: &mut FileWriter<impl Write + Seek>,
    pages: Pages,
    size: [u32; 3],
    encoding: Encoding,
    cancel: &AtomicBool,
) -> Result<()> {
    let mut linked = pages.link()?;
    let (words, shapes) = linked.take_common();
    let common = CommonSection::new(words, || shapes, encoding).map_err(invalid)?;
    writer.common(&common).map_err(Error::Output)?;
    let dims = page_dims(size);
    let ranges = SharedRanges::new(common.words());
    let stored = |at, pages: &[Page<'_>; BUNDLE_PAGES]| {
        ranges.with(|ranges| StoredBundle::new(at, dims, pages, ranges, &common))
    };
    linked.for_each_bundle(stored, |_, bundle| {
        if cancel.load(Ordering::Relaxed) {
            return Err(Error::Interrupted);
        }
        writer.bundle(&bundle.map_err(invalid)?).map_err(Error::Output)
    })
}

/// Returns the error for pages that cannot be written.
fn invalid(fault: FormatError) -> Error {
    Error::Output(io::Error::new(ErrorKind::InvalidData, fault))
}
