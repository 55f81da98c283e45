//! A cache that a bake can do without: what a cache cannot give is baked again, and what it cannot take is not kept.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use adumbra::IoError;

use super::{BakeCache, CacheKey, Fetched, MemoryCache};

/// After so many failures without a success between them, no more is read from a cache, or written to it: a server that
/// is away takes minutes to say so.
const MOST_FAILURES: u32 = 3;

/// A cache whose failures are no errors of the bake.
pub struct BestEffortCache {
    cache: Arc<dyn BakeCache>,
    /// Has what could not be put, or could not be read again, for users that read what they have put.
    memory: Option<MemoryCache>,
    on_failure: Box<dyn Fn(&IoError) + Send + Sync>,
    has_failed: AtomicBool,
    reading: Failures,
    writing: Failures,
}

impl BestEffortCache {
    /// Wraps a cache for a bake. The first failure is passed to `on_failure`.
    pub fn new(cache: Arc<dyn BakeCache>, on_failure: impl Fn(&IoError) + Send + Sync + 'static) -> Self {
        Self {
            cache,
            memory: None,
            on_failure: Box::new(on_failure),
            has_failed: AtomicBool::new(false),
            reading: Failures::default(),
            writing: Failures::default(),
        }
    }

    /// Keeps in memory what cannot be put, and what is put while nothing can be read. A [`Baker`](crate::Baker) links
    /// what it has put.
    #[must_use]
    pub fn with_memory(self) -> Self {
        Self { memory: Some(MemoryCache::default()), ..self }
    }

    /// Passes on what `attempt` returns. `None` if it fails, or is not tried.
    fn attempt<T>(
        &self,
        failures: &Failures,
        attempt: impl FnOnce(&dyn BakeCache) -> Result<T, IoError>,
    ) -> Option<T> {
        if failures.are_too_many() {
            return None;
        }
        match attempt(&*self.cache) {
            Ok(done) => {
                failures.reset();
                Some(done)
            }
            Err(error) => {
                failures.count();
                if !self.has_failed.swap(true, Ordering::Relaxed) {
                    (self.on_failure)(&error);
                }
                None
            }
        }
    }
}

impl fmt::Debug for BestEffortCache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("BestEffortCache").field(&self.cache).finish()
    }
}

impl BakeCache for BestEffortCache {
    fn get(&self, key: &CacheKey, most_bytes: u64) -> Result<Fetched, IoError> {
        match self.memory.as_ref().map(|memory| memory.get(key, most_bytes)).transpose()? {
            None | Some(Fetched::Nothing) => {}
            Some(found) => return Ok(found),
        }
        let found = self.attempt(&self.reading, |cache| cache.get(key, most_bytes));
        Ok(found.unwrap_or(Fetched::Nothing))
    }

    fn put(&self, key: &CacheKey, bytes: &[u8]) -> Result<(), IoError> {
        let is_there = self.attempt(&self.writing, |cache| cache.put(key, bytes)).is_some();
        match &self.memory {
            Some(memory) if !is_there || self.reading.are_too_many() => memory.put(key, bytes),
            _ => Ok(()),
        }
    }

    fn tidy(&self) {
        if let Some(memory) = &self.memory {
            memory.tidy();
        }
    }
}

/// Failures in a row.
#[derive(Default)]
struct Failures(AtomicU32);

impl Failures {
    fn are_too_many(&self) -> bool {
        self.0.load(Ordering::Relaxed) >= MOST_FAILURES
    }

    fn count(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    fn reset(&self) {
        // Other threads may have failed for good meanwhile.
        let _ =
            self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| (n < MOST_FAILURES).then_some(0));
    }
}
