//! The cache of bakes: entries, each of which is what a bake has made of a part of its grid, under a key of
//! all that it was made from.
//!
//! A part is a root block, or a page where root blocks are smaller. Its entry has its pages before they are
//! linked, so it can be used with any other entries of the same grid. Linking always runs over all pages, so
//! a bake that uses entries writes the same bytes as one that does not.
//!
//! | file | contents |
//! |---|---|
//! | `key.rs` | the key of an entry; `inputs.rs` of this crate computes it |
//! | `entry.rs` | the bytes of an entry |
//! | `disk.rs` | a cache in a folder |
//! | `memory.rs` | a cache in memory |
//! | `best_effort.rs` | a cache whose failures do not stop a bake |
//! | `part_grid.rs` | how a grid is divided into parts |
//! | `part_cache.rs` | the entries of one bake: which are there, and where the others go |
//!
//! Source: build systems that keep results by what they were made from, such as Bazel (Google, 2015).

mod best_effort;
mod disk;
mod entry;
mod key;
mod memory;
mod part_cache;
mod part_grid;
#[cfg(test)]
mod tests;

use std::fmt;
use std::sync::Arc;

use adumbra::IoError;

pub use best_effort::BestEffortCache;
pub use disk::{CacheReport, DiskCache};
pub use entry::ENTRY_MAGIC;
pub use key::CacheKey;
pub use memory::MemoryCache;
pub(crate) use part_cache::PartCache;
pub(crate) use part_grid::PartGrid;

/// The result of [`BakeCache::get`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fetched {
    /// The bytes of an entry.
    Whole(Vec<u8>),
    /// The length in bytes of an entry that exceeds the limit. Its bytes were not read.
    TooLong(u64),
    /// There is no entry under this key.
    Nothing,
}

/// A store of bake results: entries under their keys. Several bakes may use one at the same time, on one
/// machine or many, since all of them write the same bytes under the same key.
pub trait BakeCache: fmt::Debug + Send + Sync {
    /// Reads an entry of at most `most_bytes`.
    ///
    /// # Errors
    /// Returns [`IoError`] if it cannot be read.
    fn get(&self, key: &CacheKey, most_bytes: u64) -> Result<Fetched, IoError>;

    /// Writes an entry. Whenever the program ends, the entry must be complete or absent.
    ///
    /// # Errors
    /// Returns [`IoError`] if it cannot be written.
    fn put(&self, key: &CacheKey, bytes: &[u8]) -> Result<(), IoError>;

    /// Drops entries that were neither read nor written since the last call, if the cache holds them in
    /// memory. [`Baker`](crate::Baker) calls it after it has linked a file of all levels, when it has read
    /// every entry that it needs.
    fn tidy(&self) {}

    /// Whether this process wrote every entry, so that entries need no validation.
    fn is_trusted(&self) -> bool {
        false
    }
}

/// A shared cache. Every method forwards to it, those with a default too.
impl<C: BakeCache + ?Sized> BakeCache for Arc<C> {
    fn get(&self, key: &CacheKey, most_bytes: u64) -> Result<Fetched, IoError> {
        (**self).get(key, most_bytes)
    }

    fn put(&self, key: &CacheKey, bytes: &[u8]) -> Result<(), IoError> {
        (**self).put(key, bytes)
    }

    fn tidy(&self) {
        (**self).tidy();
    }

    fn is_trusted(&self) -> bool {
        (**self).is_trusted()
    }
}
