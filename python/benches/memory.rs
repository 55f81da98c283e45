//! How much memory a call needs, as Linux measures it.

use std::fs;
use std::io::{Error, Result};

/// Runs `call`, and returns its result with the bytes that it held at its peak beyond those held before.
pub(crate) fn measured<T>(call: impl FnOnce() -> T) -> Result<(T, u64)> {
    // This sets the peak to what is held now.
    fs::write("/proc/self/clear_refs", "5")?;
    let before = peak_bytes()?;
    let result = call();
    Ok((result, peak_bytes()? - before))
}

fn peak_bytes() -> Result<u64> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.trim().strip_suffix(" kB")).and_then(|kib| kib.parse::<u64>().ok());
    kib.map(|kib| kib * 1024).ok_or_else(|| Error::other("no VmHWM in /proc/self/status"))
}
