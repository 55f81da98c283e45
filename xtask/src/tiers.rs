//! The tests of the workspace, in two tiers: the tests of each push, with a share of the slow tests; and all
//! tests.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::Instant;

use crate::runner::{self, Tests};
use crate::steps::{Cargo, PROFILE, Steps, target_folder};
use crate::{check, docs, rustdoc, steps, tools};

/// The encoders that tests of compressed scenes run.
const ENCODERS: &str = "xtask/encoders";
/// Seconds during which each push starts slow tests. Tests that have started run to their end.
const SHARE_SECONDS: u64 = 60;
/// Approximate number of slow tests that run within [`SHARE_SECONDS`].
const SHARE_TESTS: usize = 9;
/// Number of slow tests that are started at a time.
const BATCH: usize = 3;

/// Runs everything that each push must pass: formatting, lints, every test that is not marked slow,
/// documentation, the documents with most commands parsed only, and a share of the slow tests. The share
/// changes with each commit.
pub(crate) fn push(root: &Path) -> Result<(), String> {
    let mut steps = Steps::default();
    steps.run("tools", tools::ensure_documents);
    steps.run("format", || check::format(root));
    steps.run("lean program", || check::lean_program(root));
    if build(root, &mut steps) {
        steps.run("tests", || run(root, &Tests::NotSlow, &[FIXED]));
        steps.run("documentation", || documentation(root));
        steps.run("documents", || docs::run(root, &["--parse"]).map_err(|e| e.to_string()));
        if runner::has_nextest() {
            steps.run("share of the slow tests", || share(root));
        }
    }
    steps.finish()
}

/// Runs everything that [`push`] runs, all tests marked slow, and the documents' commands with smaller
/// numbers. A test fails if a tool that it needs is missing.
pub(crate) fn long(root: &Path) -> Result<(), String> {
    let mut steps = Steps::default();
    steps.run("tools", tools::ensure_all);
    check::run(root, &mut steps);
    steps
        .run("encoders", || steps::run(&root.join(ENCODERS), "npm", &["ci", "--no-audit", "--no-fund"], &[]));
    if build(root, &mut steps) {
        steps.run("tests", || run(root, &Tests::All, &[("ADUMBRA_REQUIRE_TOOLS", "1")]));
        steps.run("documentation", || documentation(root));
        steps.run("documents", || docs::run(root, &["--quick"]).map_err(|e| e.to_string()));
        steps.run("instruction counts", || crate::count(root, &["count"]));
    }
    steps.finish()
}

/// The seed of tests with random input, so that the outcome of a push does not depend on luck. The long tier
/// uses a new seed each time.
const FIXED: (&str, &str) = ("PROPTEST_RNG_SEED", "1");

/// Builds and lints the programs, the examples and all tests.
fn build(root: &Path, steps: &mut Steps) -> bool {
    steps.run("build", || {
        Cargo::linting(root)?.run(&["test", "--no-run", "--quiet", "--profile", PROFILE, "--workspace"])
    })
}

fn documentation(root: &Path) -> Result<(), String> {
    rustdoc::test(Cargo::linting(root)?, &target_folder(root))
}

/// Runs slow tests for about a minute, starting at a different position in their list with each commit.
fn share(root: &Path) -> Result<(), String> {
    let commits = steps::output(root, "git", &["rev-list", "--count", "HEAD"])?;
    let commits: usize = commits.trim().parse().map_err(|_| format!("git counts {commits:?} commits"))?;
    let mut tests = runner::slow_tests(&Cargo::linting(root)?, PROFILE, &["--workspace"])?;
    in_order_of_share(&mut tests, commits);
    let (start, mut begun, mut outcome) = (Instant::now(), 0, Ok(()));
    for batch in tests.chunks(BATCH) {
        if start.elapsed().as_secs() >= SHARE_SECONDS {
            break;
        }
        begun += batch.len();
        outcome = run(root, &Tests::Slow(batch), &[FIXED]).and(outcome);
    }
    println!("{begun} of {} slow tests were run", tests.len());
    outcome.map_err(|fault| {
        let repeat =
            format!("cargo nextest run --cargo-profile {PROFILE} --run-ignored only -E 'test(=NAME)'");
        format!("{fault}\nrepeat one test with: {repeat}")
    })
}

/// Puts slow tests in the order in which the push after `commits` commits runs them. Tests are sorted by
/// checksum, so that the tests of one crate are spread. The start moves by [`SHARE_TESTS`] with each commit.
fn in_order_of_share(tests: &mut [String], commits: usize) {
    tests.sort_by_key(|test| crc32fast::hash(test.as_bytes()));
    if !tests.is_empty() {
        tests.rotate_left(commits * SHARE_TESTS % tests.len());
    }
}

/// Runs tests of the workspace, and prints which of them were left out because something that they need is
/// missing.
fn run(root: &Path, tests: &Tests<'_>, variables: &[(&'static str, &str)]) -> Result<(), String> {
    let list = target_folder(root).join("left-out");
    _ = fs::remove_file(&list);
    let mut cargo = Cargo::linting(root)?.with("ADUMBRA_LEFT_OUT", list.to_string_lossy());
    for (name, value) in variables {
        cargo = cargo.with(name, *value);
    }
    let outcome = runner::run(&cargo, PROFILE, &["--workspace"], tests);
    let left_out = fs::read_to_string(&list).unwrap_or_default();
    // A test may lack several things.
    let left_out: BTreeMap<&str, &str> = left_out.lines().filter_map(|line| line.split_once(": ")).collect();
    if !left_out.is_empty() {
        println!("{} tests were left out:", left_out.len());
        left_out.iter().for_each(|(test, reason)| println!("  {test}: {reason}"));
    }
    outcome
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_slow_test_runs_within_a_few_commits() {
        let names: Vec<String> = (0..150).map(|i| format!("test {i}")).collect();
        let mut run = std::collections::BTreeSet::new();
        for commits in 700..717 {
            let mut tests = names.clone();
            in_order_of_share(&mut tests, commits);
            assert_eq!(tests.len(), names.len());
            run.extend(tests.into_iter().take(SHARE_TESTS));
        }
        assert_eq!(run.len(), names.len());
        in_order_of_share(&mut [], 700);
    }
}
