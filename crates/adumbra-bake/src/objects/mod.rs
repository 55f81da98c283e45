//! Objects: what a bake has made of a part of its grid, kept for the next bake under a key of all that it was made from.
//!
//! A part is a root block, or a page where root blocks are smaller. Its object has its pages before they are linked, so
//! it can be used with any other objects of the same grid. Linking always runs over all pages, so a bake that uses
//! objects writes the same bytes as one that does not.
//!
//! | file | contents |
//! |---|---|
//! | `key.rs` | the name of an object; `inputs.rs` of this crate makes it |
//! | `object.rs` | the bytes of an object |
//! | `folder.rs` | objects in a folder |
//! | `memory.rs` | objects in memory |
//! | `cache.rs` | objects that a bake can do without |
//! | `keeper.rs` | which parts of a bake are there, and what becomes of the others |
//!
//! Source: build systems that keep results by what they were made from, such as Bazel (Google, 2015).

mod cache;
mod folder;
mod keeper;
mod key;
mod memory;
mod object;
#[cfg(test)]
mod tests;

use std::fmt;

use adumbra::IoError;

pub use cache::CachedObjects;
pub use folder::{FolderContents, FolderObjects, FolderReport};
pub(crate) use keeper::{Keeper, Parts};
pub use key::ObjectKey;
pub use memory::MemoryObjects;
pub use object::OBJECT_MAGIC;
pub(crate) use object::PageObject;

/// What is kept under a key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fetched {
    /// The bytes of an object.
    Whole(Vec<u8>),
    /// An object of so many bytes, more than were asked for. They were not read.
    TooLong(u64),
    /// Nothing, or what cannot be an object.
    Nothing,
}

/// Keeps objects. Several bakes may use one at the same time, on one machine or many: whoever writes an object last writes
/// the same bytes as the others.
pub trait Objects: fmt::Debug + Send + Sync {
    /// Returns an object, if it has at most `most_bytes`.
    ///
    /// # Errors
    /// Returns [`IoError`] if it cannot be read.
    fn get(&self, key: &ObjectKey, most_bytes: u64) -> Result<Fetched, IoError>;

    /// Keeps an object. It must be whole or not there, whenever the program ends.
    ///
    /// # Errors
    /// Returns [`IoError`] if it cannot be written.
    fn put(&self, key: &ObjectKey, bytes: &[u8]) -> Result<(), IoError>;

    /// Removes what was neither read nor put since the last call, where that is only in memory. Called once everything that is
    /// still needed has been read.
    fn tidy(&self) {}

    /// Whether every object is one that this process has put there, so that none needs a check.
    fn are_own(&self) -> bool {
        false
    }
}
