//! Faults, and when failed parts are requested again.

use std::collections::HashMap;
use std::fmt;
use std::time::Duration;

use crate::error::FormatError;
use crate::stream::SourceError;

/// The reason why a part of a file is missing.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StreamError {
    /// The source yields no bytes.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The bytes are not valid.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The budget is too small for the coarsest level.
    #[error(
        "the coarsest level takes {needed} bytes, but the budget is {budget}; give it more, or bake more levels (`bake --levels`)"
    )]
    Budget {
        /// Bytes that are needed.
        needed: u64,
        /// Bytes that may be used.
        budget: u64,
    },
}

impl StreamError {
    /// Whether another request is useless.
    pub(super) fn is_final(&self) -> bool {
        matches!(self, Self::Source(SourceError::Changed) | Self::Budget { .. })
    }
}

/// A part of a file that could not be loaded. A coarser level answers in its place.
#[derive(Debug, thiserror::Error)]
#[error("the {part} is missing: {error}{}", again(*retry_in))]
pub struct StreamFault {
    /// The part: "beginning", "common section of level 0", "bundle 7 of level 0".
    pub part: String,
    /// The reason.
    #[source]
    pub error: StreamError,
    /// Time until the part is requested again; `None`: never.
    pub retry_in: Option<Duration>,
}

/// Returns the end of a fault's message: when the part is requested again.
fn again(retry_in: Option<Duration>) -> String {
    retry_in.map_or_else(String::new, |wait| format!("; it is asked for again in {} s", wait.as_secs_f64()))
}

/// A part of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Part {
    Beginning,
    Common { level: u32 },
    Bundle(BundleId),
}

/// A bundle by level and index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct BundleId {
    pub(super) level: u32,
    pub(super) index: u32,
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Beginning => f.write_str("beginning"),
            Self::Common { level } => write!(f, "common section of level {level}"),
            Self::Bundle(BundleId { level, index }) => write!(f, "bundle {index} of level {level}"),
        }
    }
}

/// The failed parts, and when they are requested again.
#[derive(Debug, Default)]
pub(super) struct Retries {
    failed: HashMap<Part, Failed>,
}

#[derive(Debug)]
struct Failed {
    times: u32,
    not_before: Duration,
}

impl Retries {
    /// Records that a part failed. Returns the delay before the next request: 1 s, 2 s, 4 s … at most 60 s.
    pub(super) fn fail(&mut self, part: Part, now: Duration) -> Duration {
        const LONGEST_S: u64 = 60;
        let failed = self.failed.entry(part).or_insert(Failed { times: 0, not_before: now });
        let wait = Duration::from_secs((1 << failed.times.min(6)).min(LONGEST_S));
        failed.times += 1;
        failed.not_before = now + wait;
        wait
    }

    /// Records that a part was loaded.
    pub(super) fn succeed(&mut self, part: Part) {
        if !self.failed.is_empty() {
            self.failed.remove(&part);
        }
    }

    /// Whether a part may be requested now.
    pub(super) fn allow(&self, part: Part, now: Duration) -> bool {
        self.failed.get(&part).is_none_or(|failed| failed.not_before <= now)
    }

    /// Whether no requested part is missing because of a fault.
    pub(super) fn is_empty(&self) -> bool {
        self.failed.is_empty()
    }

    /// Lets all failed parts be requested again immediately.
    pub(super) fn forget(&mut self) {
        self.failed.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waits_double_up_to_a_minute() {
        let mut retries = Retries::default();
        let part = Part::Common { level: 1 };
        let waits: Vec<u64> = (0..9).map(|_| retries.fail(part, Duration::ZERO).as_secs()).collect();
        assert_eq!(waits, [1, 2, 4, 8, 16, 32, 60, 60, 60]);
        assert!(!retries.allow(part, Duration::from_secs(59)));
        assert!(retries.allow(part, Duration::from_secs(60)));
        assert!(retries.allow(Part::Beginning, Duration::ZERO));
        retries.succeed(part);
        assert_eq!(retries.fail(part, Duration::ZERO).as_secs(), 1);
    }
}
