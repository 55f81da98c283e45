//! The thread pools on which work runs.

use std::mem;
use std::process;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::errors::Failure;

/// A pool with one thread per core, and the id of the process that started it. A forked process inherits the
/// pool without its threads.
static SHARED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Returns a pool of `threads` threads, or the shared one if that is `None`.
pub(crate) fn pool(threads: Option<usize>) -> Result<Arc<ThreadPool>, Failure> {
    match threads {
        Some(threads) => start(threads),
        None => shared(),
    }
}

fn shared() -> Result<Arc<ThreadPool>, Failure> {
    let own = process::id();
    let mut shared = SHARED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((process, pool)) = &*shared
        && *process == own
    {
        return Ok(Arc::clone(pool));
    }
    let pool = start(0)?;
    // A pool of another process cannot be shut down here.
    mem::forget(shared.replace((own, Arc::clone(&pool))));
    Ok(pool)
}

/// Starts a pool; 0 threads means one per core.
fn start(threads: usize) -> Result<Arc<ThreadPool>, Failure> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map(Arc::new).map_err(|error| Failure::Value(format!("cannot start {threads} threads: {error}")))
}
