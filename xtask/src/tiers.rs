//! The tests of the workspace, in tiers: those of each push, with a share of the others, and all.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::runner::{self, Tests};
use crate::steps::{Cargo, PROFILE, Steps, target_folder};
use crate::{check, docs, rustdoc, steps, tools};

/// The encoders that tests of compressed scenes run.
const ENCODERS: &str = "xtask/encoders";
/// Each push runs one of so many shares of the tests marked slow.
const SHARES: u32 = 16;

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

/// Runs some of the slow tests: by their names and the number of commits, so that all have been run after [`SHARES`] commits.
fn share(root: &Path) -> Result<(), String> {
    let commits = steps::output(root, "git", &["rev-list", "--count", "HEAD"])?;
    let commits: u32 = commits.trim().parse().map_err(|_| format!("git counts {commits:?} commits"))?;
    let is_chosen = |name: &str| crc32fast::hash(name.as_bytes()) % SHARES == commits % SHARES;
    run(root, &Tests::Slow(&is_chosen), &[FIXED]).map_err(|fault| {
        let repeat =
            format!("cargo nextest run --cargo-profile {PROFILE} --run-ignored only -E 'test(=NAME)'");
        format!("{fault}\nrepeat one test with: {repeat}")
    })
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
