//! Objects in memory, for tests.

use std::collections::HashMap;
use std::sync::Mutex;

use adumbra::IoError;
use adumbra_bake::{ObjectKey, Objects};

/// Objects in memory.
#[derive(Debug, Default)]
pub(crate) struct InMemory(pub(crate) Mutex<HashMap<ObjectKey, Vec<u8>>>);

impl Objects for InMemory {
    fn get(&self, key: &ObjectKey) -> Result<Option<Vec<u8>>, IoError> {
        Ok(self.0.lock().unwrap().get(key).cloned())
    }

    fn put(&self, key: &ObjectKey, bytes: &[u8]) -> Result<(), IoError> {
        self.0.lock().unwrap().insert(*key, bytes.to_vec());
        Ok(())
    }
}

impl InMemory {
    pub(crate) fn len(&self) -> usize {
        self.0.lock().unwrap().len()
    }
}
