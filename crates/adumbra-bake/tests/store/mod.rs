//! Entries in memory, for tests.

use std::collections::HashMap;
use std::sync::Mutex;

use adumbra::IoError;
use adumbra_bake::{BakeCache, CacheKey, Fetched};

/// Entries in memory.
#[derive(Debug, Default)]
pub(crate) struct InMemory(pub(crate) Mutex<HashMap<CacheKey, Vec<u8>>>);

impl BakeCache for InMemory {
    fn get(&self, key: &CacheKey, most_bytes: u64) -> Result<Fetched, IoError> {
        Ok(match self.0.lock().unwrap().get(key) {
            Some(bytes) if bytes.len() as u64 > most_bytes => Fetched::TooLong(bytes.len() as u64),
            Some(bytes) => Fetched::Whole(bytes.clone()),
            None => Fetched::Nothing,
        })
    }

    fn put(&self, key: &CacheKey, bytes: &[u8]) -> Result<(), IoError> {
        self.0.lock().unwrap().insert(*key, bytes.to_vec());
        Ok(())
    }
}

impl InMemory {
    pub(crate) fn len(&self) -> usize {
        self.0.lock().unwrap().len()
    }
}
