//! Limits how much memory a load may hold.
//!
//! A few bytes of a scene file can request a great deal of memory: an image of one colour, or a thousand
//! primitives that share their vertices. Allocations are therefore counted before they are made. Only the
//! large ones are counted: files, JSON objects, texels, triangles, vertices, instances and animation keys.

use std::cell::Cell;
use std::path::Path;

use crate::error::{Error, Result};

/// Bytes that a load may hold if the caller gives no limit, whatever the size of its files.
pub(super) const BASE_BYTES: u64 = 2 << 30;
/// Additional bytes per byte of the load's files that it may hold if the caller gives no limit.
pub(super) const BYTES_PER_FILE_BYTE: u64 = 64;

/// Counts the bytes that a load holds.
pub(super) struct Budget<'a> {
    scene: &'a Path,
    given_bytes: Option<u64>,
    held_bytes: Cell<u64>,
    file_bytes: Cell<u64>,
    decoded_bytes: Cell<u64>,
}

impl<'a> Budget<'a> {
    pub(super) fn new(scene: &'a Path, given_bytes: Option<u64>) -> Self {
        Self {
            scene,
            given_bytes,
            held_bytes: Cell::new(0),
            file_bytes: Cell::new(0),
            decoded_bytes: Cell::new(0),
        }
    }

    /// Raises the default limit, which grows with the size of the scene's files.
    pub(super) fn allow_for(&self, file_bytes: u64) {
        self.file_bytes.set(self.file_bytes.get().saturating_add(file_bytes));
    }

    /// Counts `bytes` before they are allocated; `what` describes them in the error.
    ///
    /// # Errors
    /// Returns [`Error::SceneMemory`] if this exceeds the limit; nothing is counted then.
    pub(super) fn charge(&self, bytes: u64, what: impl FnOnce() -> String) -> Result<()> {
        let needed_bytes = self.held_bytes.get().saturating_add(bytes);
        let limit_bytes = self.limit_bytes();
        if needed_bytes > limit_bytes {
            let path = self.scene.to_owned();
            return Err(Error::SceneMemory { path, what: what(), needed_bytes, limit_bytes });
        }
        self.held_bytes.set(needed_bytes);
        Ok(())
    }

    /// Records that counted bytes have been freed.
    pub(super) fn release(&self, bytes: u64) {
        self.held_bytes.set(self.held_bytes.get().saturating_sub(bytes));
    }

    /// Counts `bytes` that are about to be decoded. They are never released: decoding takes time even if the
    /// result is not kept, and a small file can request the same image many times, through views of different
    /// lengths. The limit on all decoded bytes is the default memory limit, or the caller's if that is
    /// larger.
    ///
    /// # Errors
    /// Returns [`Error::SceneMemory`] if this exceeds the limit.
    pub(super) fn charge_decoding(&self, bytes: u64, what: impl FnOnce() -> String) -> Result<()> {
        let needed_bytes = self.decoded_bytes.get().saturating_add(bytes);
        let limit_bytes = self.default_limit_bytes().max(self.limit_bytes());
        if needed_bytes > limit_bytes {
            let path = self.scene.to_owned();
            return Err(Error::SceneMemory { path, what: what(), needed_bytes, limit_bytes });
        }
        self.decoded_bytes.set(needed_bytes);
        Ok(())
    }

    fn limit_bytes(&self) -> u64 {
        self.given_bytes.unwrap_or_else(|| self.default_limit_bytes())
    }

    fn default_limit_bytes(&self) -> u64 {
        BASE_BYTES.saturating_add(BYTES_PER_FILE_BYTE.saturating_mul(self.file_bytes.get()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_is_the_callers_or_grows_with_file_size() {
        let path = Path::new("scene.glb");
        let given = Budget::new(path, Some(100));
        given.allow_for(1 << 40);
        given.charge(60, String::new).expect("fits");
        let error = given.charge(60, || "the texture".to_owned()).expect_err("60 and 60 are more than 100");
        assert!(matches!(&error, Error::SceneMemory { needed_bytes: 120, limit_bytes: 100, .. }), "{error}");
        assert!(error.to_string().contains("the texture"), "{error}");
        given.release(30);
        given.charge(60, String::new).expect("30 and 60 fit");

        let default = Budget::new(path, None);
        default.charge(BASE_BYTES, String::new).expect("fits");
        default.charge(BYTES_PER_FILE_BYTE, String::new).expect_err("no file allows it");
        default.allow_for(1);
        default.charge(BYTES_PER_FILE_BYTE, String::new).expect("fits");
        default.charge(u64::MAX, String::new).expect_err("no overflow");
    }

    #[test]
    fn decoded_bytes_are_never_released() {
        let path = Path::new("scene.glb");
        for (given, limit) in
            [(None, BASE_BYTES), (Some(1), BASE_BYTES), (Some(2 * BASE_BYTES), 2 * BASE_BYTES)]
        {
            let budget = Budget::new(path, given);
            budget.charge_decoding(limit - 1, String::new).expect("fits");
            budget.charge_decoding(1, String::new).expect("fits");
            budget.release(limit);
            let error = budget.charge_decoding(1, String::new).expect_err("nothing is given back");
            assert!(
                matches!(error, Error::SceneMemory { limit_bytes, .. } if limit_bytes == limit),
                "{error}"
            );
            budget.allow_for(1);
            assert_eq!(budget.charge_decoding(1, String::new).is_ok(), limit == BASE_BYTES);
        }
    }
}
