//! Root blocks that are smaller than pages, kept while a scene is edited. A page of a coarse level has most
//! triangles of the scene in reach, but an edit touches few of its root blocks.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use crate::cache::CacheKey;

/// The root blocks that were built last, one at each place, by level of detail and number.
pub(crate) type RecentBlocks<B> = Mutex<HashMap<(usize, usize), (CacheKey, Arc<B>)>>;

/// The recent root blocks of one level, and the keys of those that are to be built.
pub(crate) struct RecentOfLevel<B> {
    pub(crate) all: Arc<RecentBlocks<B>>,
    pub(crate) level: usize,
    pub(crate) keys: HashMap<usize, CacheKey>,
}

impl<B: Clone> RecentOfLevel<B> {
    /// Returns a root block if it was built from the same inputs.
    pub(crate) fn get(&self, number: usize) -> Option<B> {
        let key = self.keys.get(&number)?;
        let block = {
            let all = self.all.lock().unwrap_or_else(|e| e.into_inner());
            let (known, block) = all.get(&(self.level, number))?;
            (known == key).then(|| Arc::clone(block))?
        };
        // The block is copied after the lock is released.
        Some(B::clone(&block))
    }

    /// Stores a root block, and drops the earlier one at its place.
    pub(crate) fn put(&self, number: usize, block: &B) {
        if let Some(key) = self.keys.get(&number) {
            let block = Arc::new(block.clone());
            let mut all = self.all.lock().unwrap_or_else(|e| e.into_inner());
            all.insert((self.level, number), (*key, block));
        }
    }
}
