//! A cache that a bake can do without: parts that it cannot return are baked again, and parts that it cannot
//! store are not kept.

use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use adumbra::IoError;

use super::{BakeCache, CacheKey, Fetched, MemoryCache};

/// After this many consecutive failures, reading from the cache stops, or writing to it: each access to an
/// unreachable server may take minutes to fail.
const MOST_FAILURES: u32 = 3;

/// A cache whose failures do not fail the bake.
pub struct BestEffortCache {
    cache: Box<dyn BakeCache>,
    /// Keeps entries that the cache could not store or can no longer read, for users that read back their own
    /// entries.
    memory: Option<MemoryCache>,
    on_failure: Box<dyn Fn(&IoError) + Send + Sync>,
    has_failed: AtomicBool,
    reading: Failures,
    writing: Failures,
}

impl BestEffortCache {
    /// Wraps a cache for a bake. The first failure is passed to `on_failure`.
    pub fn new(
        cache: impl BakeCache + 'static,
        on_failure: impl Fn(&IoError) + Send + Sync + 'static,
    ) -> Self {
        Self {
            cache: Box::new(cache),
            memory: None,
            on_failure: Box::new(on_failure),
            has_failed: AtomicBool::new(false),
            reading: Failures::default(),
            writing: Failures::default(),
        }
    }

    /// Keeps entries in memory that the cache cannot store, and all entries once reading has stopped. A
    /// [`Baker`](crate::Baker) reads back its own entries to link them.
    #[must_use]
    pub fn with_memory(self) -> Self {
        Self { memory: Some(MemoryCache::default()), ..self }
    }

    /// Returns the result of `attempt`, or `None` if it fails or is skipped.
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
        // Keep a count that other threads have raised to the limit meanwhile.
        let _ =
            self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| (n < MOST_FAILURES).then_some(0));
    }
}
