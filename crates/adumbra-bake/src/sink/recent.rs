//! Root blocks that are smaller than pages, kept while a scene is edited. A page of a coarse level has most
//! triangles of the scene in reach, but an edit touches few of its root blocks.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard};

use crate::cache::CacheKey;

/// The root blocks that were built last, one at each place.
pub(crate) struct RecentBlocks<B>(Mutex<Blocks<B>>);

/// By level of detail and number.
type Blocks<B> = HashMap<(usize, usize), (CacheKey, Arc<B>)>;

impl<B> Default for RecentBlocks<B> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

/// The recent root blocks of one level, and the keys of those that are to be built.
pub(crate) struct RecentOfLevel<B> {
    pub(crate) all: Arc<RecentBlocks<B>>,
    pub(crate) level: usize,
    pub(crate) keys: HashMap<usize, CacheKey>,
}

impl<B> RecentBlocks<B> {
    fn lock(&self) -> MutexGuard<'_, Blocks<B>> {
        self.0.lock().unwrap_or_else(|e| e.into_inner())
    }
}

impl<B: Clone> RecentOfLevel<B> {
    /// Returns a root block if it was built from the same inputs.
    pub(crate) fn get(&self, number: usize) -> Option<B> {
        let key = self.keys.get(&number)?;
        let found = self.all.lock().get(&(self.level, number)).filter(|(known, _)| known == key)?.1.clone();
        Some(B::clone(&found))
    }

    /// Stores a root block, and drops the earlier one at its place.
    pub(crate) fn put(&self, number: usize, block: &B) {
        if let Some(key) = self.keys.get(&number) {
            let block = Arc::new(block.clone());
            self.all.lock().insert((self.level, number), (*key, block));
        }
    }
}
