//! A source with the latency of a server.

use std::ops::Range;
use std::time::Duration;

use adumbra::stream::{ShadowSource, SourceError};

/// A source that waits before it answers.
pub(super) struct Delayed<S> {
    source: S,
    latency: Duration,
}

impl<S> Delayed<S> {
    pub(super) fn new(source: S, latency: Duration) -> Self {
        Self { source, latency }
    }
}

impl<S: ShadowSource> ShadowSource for Delayed<S> {
    fn read(&self, range: Range<u64>) -> Result<Vec<u8>, SourceError> {
        std::thread::sleep(self.latency);
        self.source.read(range)
    }
}
