//! Work behind the window: its threads, and what becomes of work that breaks down.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread;

use crate::news::{News, Teller};

/// Threads for work behind the window: one core stays for it.
pub(crate) fn background_pool() -> Result<rayon::ThreadPool, String> {
    let cores = thread::available_parallelism().map_or(1, |n| n.get());
    let threads = cores.saturating_sub(1).max(1);
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| e.to_string())
}

/// Does `work` on a thread of its own and tells the news that `news` makes of what comes of it; a panic is an error too.
pub(crate) fn in_background<T>(
    teller: Teller,
    work: impl FnOnce() -> Result<T, String> + Send + 'static,
    news: impl FnOnce(Result<T, String>) -> News + Send + 'static,
) {
    thread::spawn(move || teller.tell(news(caught(work))));
}

/// What comes of `work`, of which nothing is used again if it panics.
pub(crate) fn caught<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let said = panic.downcast_ref::<String>().map(String::as_str);
        let said = said.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason was given");
        Err(format!("a fault of the program, please report it: {said}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_with_its_words() {
        assert_eq!(caught(|| Ok(7)), Ok(7));
        assert_eq!(caught::<()>(|| Err("gone".to_owned())), Err("gone".to_owned()));
        let broken = caught::<()>(|| panic!("index {} out of bounds", 9)).unwrap_err();
        assert!(broken.ends_with("index 9 out of bounds"), "{broken}");
        let pool = background_pool().unwrap();
        let broken = caught::<()>(|| pool.install(|| panic!("on another thread"))).unwrap_err();
        assert!(broken.ends_with("on another thread"), "{broken}");
    }
}
