//! The tests of the workspace, in tiers: those of each push, and all.

use std::path::Path;
use std::process::Command;

use crate::steps::{Cargo, PROFILE, Steps, target_folder};
use crate::{check, docs, rustdoc, steps, tools};

/// The encoders that tests of compressed scenes run.
const ENCODERS: &str = "xtask/encoders";

/// Runs what each push must pass: the checks, every test that is not marked slow, and the documents with their long commands
/// parsed only.
pub(crate) fn push(root: &Path) -> Result<(), String> {
    let mut steps = Steps::default();
    steps.run("tools", tools::ensure_documents);
    steps.run("format", || check::format(root));
    steps.run("lean program", || check::lean_program(root));
    if build(root, &mut steps) {
        steps.run("tests", || run(root, false, &[]));
        steps.run("documentation", || rustdoc::test(Cargo::linting(root)?, &target_folder(root)));
        steps.run("documents", || docs::run(root, &["--parse"]).map_err(|e| e.to_string()));
    }
    steps.finish()
}

/// Runs everything that [`push`] runs, the tests marked slow, and the documents' commands with smaller numbers. Without a tool
/// that a test needs, the test fails.
pub(crate) fn long(root: &Path) -> Result<(), String> {
    let mut steps = Steps::default();
    steps.run("tools", tools::ensure_all);
    check::run(root, &mut steps);
    steps
        .run("encoders", || steps::run(&root.join(ENCODERS), "npm", &["ci", "--no-audit", "--no-fund"], &[]));
    if build(root, &mut steps) {
        let required = [("ADUMBRA_REQUIRE_TOOLS", "1")];
        steps.run("tests", || run(root, true, &required));
        steps.run("documentation", || rustdoc::test(Cargo::linting(root)?, &target_folder(root)));
        steps.run("documents", || docs::run(root, &["--quick"]).map_err(|e| e.to_string()));
    }
    steps.finish()
}

/// Builds and lints the programs, the examples and all tests.
fn build(root: &Path, steps: &mut Steps) -> bool {
    steps.run("build", || {
        Cargo::linting(root)?.run(&["test", "--no-run", "--quiet", "--profile", PROFILE, "--workspace"])
    })
}

/// Runs the tests of the workspace, or all of them with those marked slow.
fn run(root: &Path, is_long: bool, variables: &[(&'static str, &str)]) -> Result<(), String> {
    let mut cargo = Cargo::linting(root)?;
    for (name, value) in variables {
        cargo = cargo.with(name, *value);
    }
    run_tests(&cargo, PROFILE, &["--workspace"], is_long)
}

/// Runs tests with cargo-nextest, or with `cargo test` where that is not installed. With `is_long` those marked slow too.
pub(crate) fn run_tests(
    cargo: &Cargo<'_>,
    profile: &str,
    targets: &[&str],
    is_long: bool,
) -> Result<(), String> {
    if !has_nextest() {
        let test = ["test", "--profile", profile, "--no-fail-fast"];
        let ignored: &[&str] = if is_long { &["--", "--include-ignored"] } else { &[] };
        return cargo.run(&[&test[..], targets, ignored].concat());
    }
    let test = ["nextest", "run", "--cargo-profile", profile];
    let long: &[&str] = if is_long { &["--profile", "long", "--run-ignored", "all"] } else { &[] };
    cargo.run(&[&test[..], targets, long].concat())
}

fn has_nextest() -> bool {
    Command::new("cargo").args(["nextest", "--version"]).output().is_ok_and(|o| o.status.success())
}
