//! The threads of a bake.

use std::{io, thread};

use rayon::{ThreadPool, ThreadPoolBuilder};

/// Makes a pool of `threads` threads; 0 stands for one less than the processor has.
pub(crate) fn pool(threads: usize) -> io::Result<ThreadPool> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let threads = if threads == 0 { cores.saturating_sub(1).max(1) } else { threads };
    ThreadPoolBuilder::new().num_threads(threads).build().map_err(io::Error::other)
}
