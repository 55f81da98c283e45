//! How much memory the process has held.

/// Largest resident size so far in bytes, where the system tells (Linux).
pub(crate) fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024)
}

/// Starts the count of [`peak_bytes`] anew, where the system lets us (Linux).
pub(crate) fn reset_peak() {
    // A system that refuses keeps counting from the program's start.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}
