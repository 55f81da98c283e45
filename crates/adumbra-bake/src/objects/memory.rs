//! Objects in memory.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard};

use adumbra::IoError;

use super::{Fetched, ObjectKey, Objects};

/// Objects in memory, for a program that bakes a scene again and again while it is edited.
#[derive(Default)]
pub struct MemoryObjects {
    held: Mutex<Held>,
}

#[derive(Default)]
struct Held {
    objects: HashMap<ObjectKey, Object>,
    /// Number of times that unused objects were removed.
    round: u64,
}

struct Object {
    bytes: Arc<[u8]>,
    used_in: u64,
}

impl MemoryObjects {
    /// Removes the objects that were neither read nor written since the last call, and returns the bytes of the others.
    pub fn remove_unused(&self) -> u64 {
        let mut held = self.held();
        let round = held.round;
        held.round += 1;
        held.objects.retain(|_, object| object.used_in == round);
        held.objects.values().map(|object| object.bytes.len() as u64).sum()
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(|e| e.into_inner())
    }
}

impl std::fmt::Debug for MemoryObjects {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "MemoryObjects of {} objects", self.held().objects.len())
    }
}

impl Objects for MemoryObjects {
    fn get(&self, key: &ObjectKey, most_bytes: u64) -> Result<Fetched, IoError> {
        let mut held = self.held();
        let round = held.round;
        let found = held.objects.get_mut(key).map(|object| {
            object.used_in = round;
            Arc::clone(&object.bytes)
        });
        drop(held);
        Ok(match found {
            Some(bytes) if bytes.len() as u64 > most_bytes => Fetched::TooLong(bytes.len() as u64),
            Some(bytes) => Fetched::Whole(bytes.to_vec()),
            None => Fetched::Nothing,
        })
    }

    fn put(&self, key: &ObjectKey, bytes: &[u8]) -> Result<(), IoError> {
        let mut held = self.held();
        let used_in = held.round;
        held.objects.insert(*key, Object { bytes: bytes.into(), used_in });
        Ok(())
    }

    fn tidy(&self) {
        self.remove_unused();
    }

    fn are_own(&self) -> bool {
        true
    }
}
