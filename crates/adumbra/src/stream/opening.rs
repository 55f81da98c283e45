//! The beginning of a file: header, directory, tables, and the coarsest level.

use std::ops::Range;
use std::sync::Arc;

use crate::error::FormatError;
use crate::file::{Contents, beginning_bytes};
use crate::layout::depths::page::{bundles, page_dims};
use crate::stream::decode::{LevelContext, LoadedBundle, Stored};
use crate::stream::retry::StreamError;

/// Bytes of the first request.
const FRONT_BYTES: u64 = 1 << 16;

/// The part of the beginning that has been read.
#[derive(Clone, Debug, Default)]
pub(super) struct Beginning {
    front: Vec<u8>,
    /// The whole beginning's length in bytes, once the header says so.
    needed: Option<u64>,
}

/// The state of opening a file.
#[derive(Debug)]
pub(super) enum Opened {
    /// More bytes are needed.
    More(Beginning),
    /// The whole beginning has been read.
    Whole(Box<OpenedFile>),
}

/// The beginning of a file.
#[derive(Debug)]
pub(super) struct OpenedFile {
    pub(super) contents: Contents,
    pub(super) coarsest: Arc<LevelContext>,
    /// Bundles of the coarsest level.
    pub(super) bundles: Vec<LoadedBundle>,
}

impl Beginning {
    /// Returns the bytes that are needed next.
    pub(super) fn range(&self) -> Range<u64> {
        self.front.len() as u64..self.needed.unwrap_or(FRONT_BYTES)
    }

    /// Continues with the bytes of [`Beginning::range`].
    pub(super) fn answer(mut self, bytes: &[u8]) -> Result<Opened, StreamError> {
        self.front.extend_from_slice(bytes);
        let (have, needed) = (self.front.len() as u64, beginning_bytes(&self.front)?);
        if needed <= have {
            return Ok(Opened::Whole(Box::new(self.whole()?)));
        }
        // A source returns fewer bytes only where the file ends.
        if self.needed.is_some() || have < FRONT_BYTES {
            return Err(FormatError::Truncated { what: "beginning".into(), needed, have }.into());
        }
        self.needed = Some(needed);
        Ok(Opened::More(self))
    }

    fn whole(&self) -> Result<OpenedFile, StreamError> {
        let contents = Contents::parse_beginning(&self.front)?;
        let level = contents.header.grids - 1;
        let entry = &contents.grids[level as usize];
        // All offsets are within the beginning.
        let part = |range: Range<u64>| &self.front[range.start as usize..range.end as usize];
        let common = part(entry.common.offset..entry.common.end());
        let coarsest = LevelContext::parse(entry, common, contents.header.encoding, level)?;
        let bytes = part(entry.bundles.offset..entry.bundles.end());
        let mut offset = 0;
        let mut loaded = Vec::new();
        let places = bundles(page_dims(entry.grid.size));
        for ((index, place), &entry) in (0..).zip(places).zip(&contents.tables[level as usize]) {
            if entry.stored_bytes != 0 {
                loaded.push(coarsest.load(&Stored { index, place, entry, offset }, bytes)?);
            }
            offset += entry.stored_bytes as usize;
        }
        Ok(OpenedFile { contents, coarsest, bundles: loaded })
    }
}
