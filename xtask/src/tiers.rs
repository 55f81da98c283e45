//! The tests of the workspace, in tiers: those of each push, with a share of the others, and all.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::Instant;

use crate::runner::{self, Tests};
use crate::steps::{Cargo, PROFILE, Steps, target_folder};
use crate::{check, docs, rustdoc, steps, tools};

/// The encoders that tests of compressed scenes run.
const ENCODERS: &str = "xtask/encoders";
/// For how long each push begins slow tests. What has begun is run to its end.
const SHARE_SECONDS: u64 = 60;
/// About as many slow tests are run within [`SHARE_SECONDS`].
const SHARE_TESTS: usize = 9;
/// As many slow tests are begun at a time.
const BATCH: usize = 3;

/// Runs what each push must pass: formatting, lints, every test that is not marked slow, documentation, the documents with most
/// commands parsed only, and a share of the tests marked slow, another one with each commit.
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

/// Runs everything that [`push`] runs, all tests marked slow, and the documents' commands with smaller numbers. Without a tool
/// that a test needs, the test fails.
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

/// The seed of tests with random input, so that a push depends on no luck. The long tier has another one each time.
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

/// Runs slow tests for about a minute, from another place in their list with each commit.
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

/// Orders slow tests as the push after so many commits runs them. The order is that of their checksums, so that those of one
/// crate are spread, and begins [`SHARE_TESTS`] further on with each commit.
fn in_order_of_share(tests: &mut [String], commits: usize) {
    tests.sort_by_key(|test| crc32fast::hash(test.as_bytes()));
    if !tests.is_empty() {
        tests.rotate_left(commits * SHARE_TESTS % tests.len());
    }
}

/// Runs tests of the workspace, and says how many of them were left out because what they need is absent.
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
    fn every_slow_test_is_soon_in_a_share() {
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
