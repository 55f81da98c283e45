//! All streamed files of an app.

use std::time::Instant;

use adumbra::stream::{SourceError, StreamCounts, StreamError, StreamOptions};
use bevy::ecs::prelude::*;

use super::file::Stream;
use super::open::OpenFile;
use crate::StreamSource;
use crate::error::BakedShadowError;

/// The files that are streamed: those of the [`BakedShadow::streams`](crate::BakedShadow::streams) of all
/// lights. A resource.
#[derive(Resource)]
pub struct ShadowStreams {
    pub(super) slots: Vec<Slot>,
    pub(super) begun: Instant,
}

/// A streamed file, and the same file while it is being reopened with other options.
pub(super) struct Slot {
    pub(super) source: StreamSource,
    pub(super) options: StreamOptions,
    pub(super) stream: Stream,
    pub(super) next: Option<Stream>,
    /// Whether the file has changed and must be reopened.
    pub(super) is_stale: bool,
}

impl Slot {
    /// Returns the newest stream, which is the one to update.
    pub(super) fn active(&mut self) -> &mut Stream {
        self.next.as_mut().unwrap_or(&mut self.stream)
    }
}

impl Default for ShadowStreams {
    fn default() -> Self {
        Self { slots: Vec::new(), begun: Instant::now() }
    }
}

impl ShadowStreams {
    /// Returns what a source has done and what is left to do; `None` if no light names it.
    pub fn counts(&self, source: &StreamSource) -> Option<StreamCounts> {
        self.slot(source).map(|slot| slot.stream.resident().counts())
    }

    /// Whether everything that cameras need and that fits the budget is in the textures, for all files. A
    /// loading screen may wait for this.
    pub fn is_settled(&self) -> bool {
        self.slots
            .iter()
            .all(|slot| slot.next.is_none() && slot.stream.is_ready() && slot.stream.resident().is_settled())
    }

    /// Requests everything that has failed again at once. A file that has changed is reopened.
    pub fn retry(&mut self) {
        for slot in &mut self.slots {
            let changed = |stream: &Stream| {
                stream
                    .fault()
                    .is_some_and(|fault| matches!(fault.error, StreamError::Source(SourceError::Changed)))
            };
            let stream = slot.active();
            if changed(stream) {
                slot.is_stale = true;
            } else {
                stream.retry();
            }
        }
    }

    fn slot(&self, source: &StreamSource) -> Option<&Slot> {
        self.slots.iter().find(|slot| slot.source == *source)
    }

    /// Returns a file once it is open.
    pub(crate) fn open_file(&self, source: &StreamSource) -> Option<OpenFile<'_>> {
        self.slot(source)?.stream.open_file()
    }

    /// Returns why a part of a file is missing.
    pub(crate) fn fault(&self, source: &StreamSource) -> Option<BakedShadowError> {
        let slot = self.slot(source)?;
        let fault = slot.next.as_ref().and_then(Stream::fault).or(slot.stream.fault())?;
        Some(BakedShadowError::Stream { file: source.to_string(), fault: fault.clone() })
    }
}
