//! Memory use of the process, and its limit.
//!
//! A library counts the memory that it holds. The program holds more: its code, its stacks, and freed memory
//! that the allocator keeps. This is measured before a library begins, and the library gets the remainder of
//! the limit. The peak of the process shows memory that was not foreseen. It is checked during a long step
//! and at its end.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::allocator;
use crate::exit::Failure;

/// Memory that the process needs in addition to what is measured and counted: code that is not loaded yet,
/// and file buffers.
const BASE_BYTES: u64 = 5 << 20;
/// The stack and the allocator's arena of a thread.
const THREAD_BYTES: u64 = 1 << 19;
/// Memory that the process holds before it loads anything, if the system does not report it.
const UNMEASURED_BYTES: u64 = 10 << 20;
/// The peak may exceed the limit by one part in this many.
const TOLERANCE: u64 = 20;
/// Free memory is returned once 1 / RETURNED_FROM of the limit is used.
const RETURNED_FROM: u64 = 2;

/// Returns the largest resident set size so far in bytes. `None` if the system does not report it; Linux
/// does.
pub fn peak_bytes() -> Option<u64> {
    status_bytes("VmHWM:")
}

/// Returns the resident set size in bytes. `None` if the system does not report it; Linux does.
fn resident_bytes() -> Option<u64> {
    status_bytes("VmRSS:")
}

fn status_bytes(field: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with(field))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024)
}

/// The limit on the memory of the whole process.
#[derive(Clone, Copy, Debug)]
pub struct MemoryLimit {
    limit_bytes: Option<u64>,
}

/// A library's share of the limit.
#[derive(Clone, Copy, Debug)]
pub struct Share {
    limit_bytes: Option<u64>,
    beside_bytes: u64,
}

impl MemoryLimit {
    /// Creates a limit; `None` is no limit.
    pub fn new(limit_bytes: Option<u64>) -> Self {
        Self { limit_bytes }
    }

    /// Whether there is a limit.
    pub(crate) fn is_given(&self) -> bool {
        self.limit_bytes.is_some()
    }

    /// Returns the share of a library that counts the memory that it holds. `counted_bytes` of it are held
    /// already.
    pub fn share(&self, counted_bytes: u64) -> Share {
        let threads = rayon::current_num_threads() as u64;
        if self.limit_bytes.is_some() {
            allocator::return_free_pages();
        }
        let held_bytes =
            resident_bytes().map_or(UNMEASURED_BYTES, |resident| resident.saturating_sub(counted_bytes));
        Share {
            limit_bytes: self.limit_bytes,
            beside_bytes: held_bytes + BASE_BYTES + threads * THREAD_BYTES,
        }
    }

    /// Returns the peak of the process if it exceeds the limit.
    pub fn exceeded_bytes(&self) -> Option<u64> {
        let limit = self.limit_bytes?;
        peak_bytes().filter(|&peak| peak > limit.saturating_add(limit / TOLERANCE))
    }

    /// Checks that the process has not exceeded the limit.
    ///
    /// # Errors
    ///
    /// Returns [`Failure::Bake`] with the peak of the process if it has. `what` names the step.
    pub fn check_peak(&self, what: &'static str) -> Result<(), Failure> {
        match (self.exceeded_bytes(), self.limit_bytes) {
            (Some(peak), Some(limit)) => Err(Failure::memory(what, peak, limit)),
            _ => Ok(()),
        }
    }
}

impl Share {
    /// Returns the bytes that the library may hold and count; `None` is no limit.
    pub fn bytes(&self) -> Option<u64> {
        self.limit_bytes.map(|limit| limit.saturating_sub(self.beside_bytes))
    }

    /// Checks that this many bytes fit into the share.
    ///
    /// # Errors
    ///
    /// Returns [`Failure::Bake`] if they do not.
    pub fn check(&self, what: &'static str, counted_bytes: u64) -> Result<(), Failure> {
        match self.excess(counted_bytes) {
            Some([needed_bytes, limit_bytes]) => Err(Failure::memory(what, needed_bytes, limit_bytes)),
            None => Ok(()),
        }
    }

    /// Returns the need of the whole process and the limit, if this many bytes do not fit into the share.
    pub(crate) fn excess(&self, counted_bytes: u64) -> Option<[u64; 2]> {
        let needed_bytes = counted_bytes.saturating_add(self.beside_bytes);
        self.limit_bytes.filter(|&limit_bytes| needed_bytes > limit_bytes).map(|limit| [needed_bytes, limit])
    }

    /// Converts a library's memory error to the whole process: adds the memory that the library does not
    /// count to its need and its limit.
    pub fn whole(&self, failure: Failure) -> Failure {
        use adumbra_bake::Error as Bake;
        use adumbra_scene::Error as Scene;
        let (Some(limit), Some(allowed)) = (self.limit_bytes, self.bytes()) else { return failure };
        let more = |needed: u64| needed.saturating_add(self.beside_bytes).max(limit.saturating_add(1));
        let bake = |error| match error {
            Bake::MemoryLimit { what, needed_bytes, limit_bytes } if limit_bytes == allowed => {
                Bake::MemoryLimit { what, needed_bytes: more(needed_bytes), limit_bytes: limit }
            }
            other => other,
        };
        match failure {
            Failure::Bake(error) => Failure::Bake(bake(error)),
            Failure::Scene(Scene::SceneMemory { path, what, needed_bytes, limit_bytes })
                if limit_bytes == allowed =>
            {
                let needed_bytes = more(needed_bytes);
                Failure::Scene(Scene::SceneMemory { path, what, needed_bytes, limit_bytes: limit })
            }
            other => other,
        }
    }
}

/// Ends a long step once the process exceeds its memory limit.
pub struct Guard {
    limit: MemoryLimit,
    cancel: AtomicBool,
    exceeded_bytes: AtomicU64,
}

impl Guard {
    /// Creates a guard for a step that ends soon after [`Guard::cancel`] is set.
    pub fn new(limit: MemoryLimit) -> Self {
        Self { limit, cancel: AtomicBool::new(false), exceeded_bytes: AtomicU64::new(0) }
    }

    /// Returns the flag that ends the step.
    pub fn cancel(&self) -> &AtomicBool {
        &self.cancel
    }

    /// Cancels the step if the process exceeds the limit. Call it from time to time. Once half of the limit
    /// is used, it returns free memory to the system: pages that have gone to disk one by one leave holes
    /// that are too small for a large table.
    pub fn look(&self) {
        let Some(limit) = self.limit.limit_bytes else { return };
        if resident_bytes().is_some_and(|bytes| bytes > limit / RETURNED_FROM) {
            allocator::return_free_pages();
        }
        if let Some(peak) = self.limit.exceeded_bytes() {
            self.exceeded_bytes.store(peak, Ordering::Relaxed);
            self.cancel.store(true, Ordering::Relaxed);
        }
    }

    /// Returns the result of the step `what`, unless the guard cancelled it.
    ///
    /// # Errors
    ///
    /// Returns the step's error in the terms of the whole process, or [`Failure::Bake`] if the process is or
    /// was beyond the limit.
    pub fn end<T>(
        &self,
        what: &'static str,
        share: &Share,
        result: Result<T, impl Into<Failure>>,
    ) -> Result<T, Failure> {
        let result = result.map_err(|error| share.whole(error.into()));
        match (self.exceeded_bytes.load(Ordering::Relaxed), self.limit.limit_bytes) {
            (peak, Some(limit)) if peak > 0 => Err(Failure::memory(what, peak, limit)),
            _ => {
                let result = result?;
                self.limit.check_peak(what)?;
                Ok(result)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn share_leaves_room_for_uncounted_memory() {
        let limit = MemoryLimit::new(Some(1 << 30));
        let share = limit.share(0);
        let bytes = share.bytes().unwrap();
        assert!(bytes > 1 << 29 && bytes < (1 << 30) - BASE_BYTES, "{share:?}");
        share.check("a thing", bytes).unwrap();
        let Err(Failure::Bake(adumbra_bake::Error::MemoryLimit { needed_bytes, limit_bytes, .. })) =
            share.check("a thing", bytes + 1)
        else {
            panic!("more than the share is refused");
        };
        assert_eq!((needed_bytes, limit_bytes), ((1 << 30) + 1, 1 << 30));
        let of_library = Failure::memory("a thing", bytes + 7, bytes);
        let Failure::Bake(adumbra_bake::Error::MemoryLimit { needed_bytes, limit_bytes, .. }) =
            share.whole(of_library)
        else {
            panic!("it stays what it was");
        };
        assert_eq!((needed_bytes, limit_bytes), ((1 << 30) + 7, 1 << 30));
        assert_eq!(MemoryLimit::new(Some(1)).share(0).bytes(), Some(0));
        assert_eq!(MemoryLimit::new(None).share(0).bytes(), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn peak_beyond_the_limit_is_found() {
        let peak = peak_bytes().unwrap();
        assert!(peak >= resident_bytes().unwrap().min(peak));
        assert!(MemoryLimit::new(Some(peak / 2)).check_peak("a thing").is_err());
        MemoryLimit::new(Some(64 * peak)).check_peak("a thing").unwrap();
        MemoryLimit::new(None).check_peak("a thing").unwrap();
    }
}
