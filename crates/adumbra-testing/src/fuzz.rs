//! What tests with random input share: for how long they run, and how much memory their process has taken.

use std::time::Duration;

/// How long a test with random input is to run: `ADUMBRA_FUZZ_SECONDS`, or `None` for the quick test.
pub fn fuzz_time() -> Option<Duration> {
    let seconds = std::env::var("ADUMBRA_FUZZ_SECONDS").ok()?;
    Some(Duration::from_secs(seconds.parse().expect("ADUMBRA_FUZZ_SECONDS is a whole number")))
}

/// The most memory that this process has had, bytes, where the system says so.
pub fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}
