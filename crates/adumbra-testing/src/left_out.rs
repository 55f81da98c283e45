//! Tests that are left out because a resource that they need is missing.

use std::io::Write as _;
use std::{env, fs, thread};

/// Records that a test is left out, and why: prints the reason, and adds a line to the file that
/// `ADUMBRA_LEFT_OUT` names, which `cargo xtask test` counts.
///
/// # Panics
/// Panics if the environment variable `required` is set.
pub fn left_out(reason: &str, required: &str) {
    assert!(env::var_os(required).is_none(), "{reason}, and {required} is set");
    eprintln!("LEFT OUT: {reason}");
    let Some(list) = env::var_os("ADUMBRA_LEFT_OUT") else { return };
    let test = env::var("NEXTEST_TEST_NAME").ok();
    let test = test.unwrap_or_else(|| thread::current().name().unwrap_or("a test").to_owned());
    let file = fs::OpenOptions::new().append(true).create(true).open(list);
    let written = file.and_then(|mut file| file.write_all(format!("{test}: {reason}\n").as_bytes()));
    written.expect("the list of tests that are left out can be written");
}
