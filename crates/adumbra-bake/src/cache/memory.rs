//! A cache in memory.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard};

use adumbra::IoError;

use super::{BakeCache, CacheKey, Fetched};

/// A cache in memory, for a program that bakes a scene again and again while it is edited.
#[derive(Default)]
pub struct MemoryCache {
    held: Mutex<Held>,
}

#[derive(Default)]
struct Held {
    entries: HashMap<CacheKey, Entry>,
    /// Number of times that unused entries were removed.
    round: u64,
}

struct Entry {
    bytes: Arc<[u8]>,
    used_in: u64,
}

impl MemoryCache {
    /// Removes the entries that were neither read nor written since the last call, and returns the bytes of
    /// the others.
    pub fn remove_unused(&self) -> u64 {
        let mut held = self.held();
        let round = held.round;
        held.round += 1;
        held.entries.retain(|_, entry| entry.used_in == round);
        held.entries.values().map(|entry| entry.bytes.len() as u64).sum()
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(|e| e.into_inner())
    }
}

impl std::fmt::Debug for MemoryCache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "MemoryCache of {} entries", self.held().entries.len())
    }
}

impl BakeCache for MemoryCache {
    fn get(&self, key: &CacheKey, most_bytes: u64) -> Result<Fetched, IoError> {
        let mut held = self.held();
        let round = held.round;
        let found = held.entries.get_mut(key).map(|entry| {
            entry.used_in = round;
            Arc::clone(&entry.bytes)
        });
        drop(held);
        Ok(match found {
            Some(bytes) if bytes.len() as u64 > most_bytes => Fetched::TooLong(bytes.len() as u64),
            Some(bytes) => Fetched::Whole(bytes.to_vec()),
            None => Fetched::Nothing,
        })
    }

    fn put(&self, key: &CacheKey, bytes: &[u8]) -> Result<(), IoError> {
        let mut held = self.held();
        let used_in = held.round;
        held.entries.insert(*key, Entry { bytes: bytes.into(), used_in });
        Ok(())
    }

    fn tidy(&self) {
        self.remove_unused();
    }

    fn is_trusted(&self) -> bool {
        true
    }
}
