//! For how long tests with random input run.

use std::time::Duration;

/// How long a test with random input is to run: `ADUMBRA_FUZZ_SECONDS`, or `None` for the quick test.
pub fn fuzz_time() -> Option<Duration> {
    let seconds = std::env::var("ADUMBRA_FUZZ_SECONDS").ok()?;
    Some(Duration::from_secs(seconds.parse().expect("ADUMBRA_FUZZ_SECONDS is a whole number")))
}
