//! Background work: its threads, and the conversion of panics into errors.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread;

/// Creates a thread pool for background work that leaves one core for the window.
pub(crate) fn background_pool() -> Result<rayon::ThreadPool, String> {
    let cores = thread::available_parallelism().map_or(1, |n| n.get());
    let threads = cores.saturating_sub(1).max(1);
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| e.to_string())
}

/// Runs `work` on a new thread and passes its result to `done` there; a panic becomes an error.
pub(crate) fn in_background<T>(
    work: impl FnOnce() -> Result<T, String> + Send + 'static,
    done: impl FnOnce(Result<T, String>) + Send + 'static,
) {
    thread::spawn(move || done(caught(work)));
}

/// Returns the result of `work`; a panic becomes an error. After a panic, nothing that `work` used may be
/// used again.
pub(crate) fn caught<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let said = panic.downcast_ref::<String>().map(String::as_str);
        let said = said.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason was given");
        Err(format!("an internal error, please report it: {said}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panic_becomes_an_error_with_its_message() {
        assert_eq!(caught(|| Ok(7)), Ok(7));
        assert_eq!(caught::<()>(|| Err("gone".to_owned())), Err("gone".to_owned()));
        let broken = caught::<()>(|| panic!("index {} out of bounds", 9)).unwrap_err();
        assert!(broken.ends_with("index 9 out of bounds"), "{broken}");
        let pool = background_pool().unwrap();
        let broken = caught::<()>(|| pool.install(|| panic!("on another thread"))).unwrap_err();
        assert!(broken.ends_with("on another thread"), "{broken}");
    }
}
