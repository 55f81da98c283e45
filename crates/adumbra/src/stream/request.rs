//! Requests to a source, and the decoding of its bytes. Nothing here needs the state of a stream, so it can
//! run on any thread.

use std::ops::Range;
use std::sync::Arc;

use crate::file::GridEntry;
use crate::settings::Encoding;
use crate::stream::decode::{LevelContext, LoadedBundle, Stored};
use crate::stream::opening::{Beginning, Opened};
use crate::stream::retry::{BundleId, Part, StreamError};
use crate::stream::{ShadowSource, SourceError};

/// A range of a file's bytes that is needed. [`Resident::next_request`](super::Resident::next_request) makes
/// it, [`Request::answer`] answers it, and [`Resident::deliver`](super::Resident::deliver) takes the answer.
#[derive(Debug)]
pub struct Request {
    pub(super) range: Range<u64>,
    pub(super) job: Job,
}

/// The use of the requested bytes.
#[derive(Debug)]
pub(super) enum Job {
    Beginning(Beginning),
    Common { entry: Box<GridEntry>, encoding: Encoding, level: u32 },
    Bundles { context: Arc<LevelContext>, bundles: Vec<Stored> },
}

/// The result of a [`Request`].
#[derive(Debug)]
pub struct Answer {
    /// Bytes that were received.
    pub(super) bytes: u64,
    pub(super) loaded: Loaded,
}

#[derive(Debug)]
pub(super) enum Loaded {
    Beginning(Result<Opened, StreamError>),
    Common { level: u32, result: Result<Arc<LevelContext>, StreamError> },
    Bundles { level: u32, bundles: Vec<(u32, Result<LoadedBundle, StreamError>)> },
}

impl Request {
    /// Returns the range of bytes to read. Only the first request, which is for the first 65,536 bytes, may
    /// reach beyond the end of the file.
    pub fn range(&self) -> Range<u64> {
        self.range.clone()
    }

    /// Reads the bytes from a source, and decodes and validates them. Cost: about 30 MB/s of decoded words.
    pub fn run(self, source: &dyn ShadowSource) -> Answer {
        let read = source.read(self.range());
        self.answer(read)
    }

    /// Decodes and validates bytes that were read elsewhere. Cost: about 30 MB/s of decoded words.
    pub fn answer(self, read: Result<Vec<u8>, SourceError>) -> Answer {
        let bytes = read.as_ref().map_or(0, |bytes| bytes.len() as u64);
        let loaded = match self.job {
            Job::Beginning(beginning) => {
                Loaded::Beginning(read.map_err(Into::into).and_then(|bytes| beginning.answer(&bytes)))
            }
            Job::Common { entry, encoding, level } => {
                let parse = |bytes: Vec<u8>| Ok(LevelContext::parse(&entry, &bytes, encoding, level)?);
                Loaded::Common { level, result: read.map_err(Into::into).and_then(parse) }
            }
            Job::Bundles { context, bundles } => {
                let level = context.level;
                let bundles = match read {
                    Ok(bytes) => bundles.iter().map(|b| (b.index, context.load(b, &bytes))).collect(),
                    Err(error) => {
                        let mut error = Some(error);
                        let text = error.as_ref().map(ToString::to_string).unwrap_or_default();
                        // The first bundle gets the error itself, the others its text.
                        let each = |b: &Stored| {
                            let error =
                                error.take().unwrap_or_else(|| SourceError::Failed(text.clone().into()));
                            (b.index, Err(error.into()))
                        };
                        bundles.iter().map(each).collect()
                    }
                };
                Loaded::Bundles { level, bundles }
            }
        };
        Answer { bytes, loaded }
    }

    /// Returns the parts of the file that the request is for.
    pub(super) fn parts(&self) -> Vec<Part> {
        match &self.job {
            Job::Beginning(_) => vec![Part::Beginning],
            Job::Common { level, .. } => vec![Part::Common { level: *level }],
            Job::Bundles { context, bundles } => bundles
                .iter()
                .map(|b| Part::Bundle(BundleId { level: context.level, index: b.index }))
                .collect(),
        }
    }
}
