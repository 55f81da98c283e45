//! The number of threads that a verb uses.

use crate::exit::Failure;

/// Runs `work` on a pool of `threads` threads, or on all cores if `threads` is `None`.
///
/// # Errors
///
/// Returns [`Failure::Usage`] if the threads cannot be started. The result of `work` is returned unchanged.
pub fn with_threads<T: Send>(threads: Option<u16>, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    let Some(threads) = threads else { return Ok(work()) };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.into())
        .build()
        .map_err(|e| Failure::Usage(format!("cannot start {threads} threads: {e}")))?;
    Ok(pool.install(work))
}
