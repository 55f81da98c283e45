//! Finds the entries of a bake, and writes those that are missing as soon as their parts are done.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use rayon::prelude::*;

use super::entry;
use super::{BakeCache, CacheKey, Fetched, PartGrid};
use crate::error::{Error, Result};
use crate::pages::OwnedPage;

/// Copies of an entry in memory while it is read: its bytes, the words of its pages, and the words that are
/// checked and that are kept.
const COPIES: u64 = 4;

/// The entries of a bake.
#[derive(Debug)]
pub(crate) struct PartCache {
    cache: Arc<dyn BakeCache>,
    pub(crate) parts: PartGrid,
    /// The key of each part; `None` for parts that the bake leaves out.
    keys: Vec<Option<CacheKey>>,
    /// Whether the entry of a part was found.
    found: Vec<AtomicBool>,
    /// Memory for entries while they are read, if it is limited.
    room_bytes: Option<u64>,
    /// Locked by a thread while it reads an entry that exceeds the thread's share of the room.
    large: Mutex<()>,
    /// Number of entries that do not fit the room, and bytes of the longest.
    left_out: AtomicUsize,
    left_out_bytes: AtomicU64,
    failure: Mutex<Option<Error>>,
}

impl PartCache {
    /// `keys` are pairs of a part's number and its key. Parts without a key are neither read nor written.
    pub(crate) fn new(
        cache: &Arc<dyn BakeCache>,
        parts: PartGrid,
        keys: impl IntoIterator<Item = (usize, CacheKey)>,
    ) -> Self {
        let found = (0..parts.count()).map(|_| AtomicBool::new(false)).collect();
        let mut all = vec![None; parts.count()];
        keys.into_iter().for_each(|(part, key)| all[part] = Some(key));
        Self {
            cache: Arc::clone(cache),
            parts,
            keys: all,
            found,
            room_bytes: None,
            large: Mutex::default(),
            left_out: AtomicUsize::new(0),
            left_out_bytes: AtomicU64::new(0),
            failure: Mutex::default(),
        }
    }

    /// Limits the memory for entries while they are read. The part of a larger entry is baked again.
    pub(crate) fn within(self, room_bytes: Option<u64>) -> Self {
        Self { room_bytes, ..self }
    }

    /// Reads all entries that the cache has, on all threads, and passes the pages of each to `take`, x
    /// fastest.
    pub(crate) fn find(&self, take: impl Fn(usize, Vec<OwnedPage>) + Sync) {
        (0..self.keys.len()).into_par_iter().for_each(|part| {
            let Some(key) = &self.keys[part] else { return };
            let (dims, take) = (self.parts.page_dims(part), |pages| take(part, pages));
            let most_bytes = entry::most_bytes(dims);
            let Some(room_bytes) = self.room_bytes else {
                self.read(part, key, most_bytes, take);
                return;
            };
            // Half of the room is for all threads, the other half for a large entry.
            let large_bytes = room_bytes / (2 * COPIES);
            let small_bytes = large_bytes / rayon::current_num_threads() as u64;
            match self.read(part, key, most_bytes.min(small_bytes), take) {
                Some(bytes) if bytes > most_bytes => {}
                Some(bytes) if bytes > large_bytes => {
                    self.left_out.fetch_add(1, Ordering::Relaxed);
                    self.left_out_bytes.fetch_max(bytes, Ordering::Relaxed);
                }
                Some(_) => {
                    let _alone = self.large.lock().unwrap_or_else(|e| e.into_inner());
                    self.read(part, key, most_bytes.min(large_bytes), take);
                }
                None => {}
            }
        });
    }

    /// Returns the number of entries that did not fit the room, and the room that the longest of them would
    /// have needed.
    pub(crate) fn left_out(&self) -> (usize, u64) {
        let bytes = 2 * COPIES * self.left_out_bytes.load(Ordering::Relaxed);
        (self.left_out.load(Ordering::Relaxed), bytes)
    }

    /// Reads the entry of a part, and passes its pages to `take`. Returns the length of an entry longer than
    /// `most_bytes`. A damaged entry counts as missing, so its part is baked again.
    fn read(
        &self,
        part: usize,
        key: &CacheKey,
        most_bytes: u64,
        take: impl FnOnce(Vec<OwnedPage>),
    ) -> Option<u64> {
        let bytes = match self.cache.get(key, most_bytes) {
            Ok(Fetched::Whole(bytes)) => bytes,
            Ok(Fetched::TooLong(bytes)) => return Some(bytes),
            Ok(Fetched::Nothing) => return None,
            Err(error) => {
                self.fail(error.into());
                return None;
            }
        };
        let dims = self.parts.page_dims(part);
        let pages = if self.cache.is_trusted() {
            entry::from_own_bytes(&bytes, dims)
        } else {
            entry::from_bytes(key, &bytes, dims)
        };
        if let Some(pages) = pages {
            take(pages);
            self.found[part].store(true, Ordering::Relaxed);
        }
        None
    }

    /// Whether the entry of a part was found.
    pub(crate) fn has(&self, part: usize) -> bool {
        self.found[part].load(Ordering::Relaxed)
    }

    /// Returns the number of root blocks whose entries were found.
    pub(crate) fn found_root_blocks(&self) -> usize {
        let found = (0..self.parts.count()).filter(|&part| self.has(part));
        found.map(|part| self.parts.root_blocks(part).count()).sum()
    }

    /// Writes the pages of a part: root, base and words of each, x fastest.
    pub(crate) fn put<'p>(&self, part: usize, pages: impl Iterator<Item = (u32, u32, &'p [u32])> + Clone) {
        let Some(key) = &self.keys[part] else { return };
        if let Err(error) = self.cache.put(key, &entry::to_bytes(key, pages)) {
            self.fail(error.into());
        }
    }

    /// Checks that all entries could be read and written.
    ///
    /// # Errors
    /// Returns the first [`Error::Io`], once.
    pub(crate) fn check(&self) -> Result<()> {
        self.failure.lock().unwrap_or_else(|e| e.into_inner()).take().map_or(Ok(()), Err)
    }

    fn fail(&self, error: Error) {
        self.failure.lock().unwrap_or_else(|e| e.into_inner()).get_or_insert(error);
    }
}
