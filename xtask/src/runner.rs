//! Runs tests with cargo-nextest, which ends stuck tests and measures all tests, or with `cargo test` if
//! cargo-nextest is not installed.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde::Deserialize;

use crate::steps::Cargo;

/// How many of the slowest tests are listed.
const SLOWEST: usize = 15;

/// The tests to run.
pub(crate) enum Tests<'a> {
    /// The tests that are not marked slow with `#[ignore]`.
    NotSlow,
    /// These filters from [`slow_tests`].
    Slow(&'a [String]),
    All,
}

pub(crate) fn has_nextest() -> bool {
    Command::new("cargo").args(["nextest", "--version"]).output().is_ok_and(|o| o.status.success())
}

/// Runs tests, and lists the slowest of them if cargo-nextest runs them. Without cargo-nextest, slow tests
/// run only as part of [`Tests::All`].
pub(crate) fn run(
    cargo: &Cargo<'_>,
    profile: &str,
    targets: &[&str],
    tests: &Tests<'_>,
) -> Result<(), String> {
    if !has_nextest() {
        let test = ["test", "--profile", profile, "--no-fail-fast"];
        let ignored: &[&str] = match tests {
            Tests::NotSlow => &[],
            Tests::Slow(_) => return Err("slow tests alone need cargo-nextest".to_owned()),
            Tests::All => &["--", "--include-ignored"],
        };
        return cargo.run(&[&test[..], targets, ignored].concat());
    }
    let base = [&["--cargo-profile", profile][..], targets].concat();
    let (settings, more): (&str, Vec<String>) = match tests {
        Tests::NotSlow => ("default", Vec::new()),
        Tests::All => ("long", ["--run-ignored", "all"].map(str::to_owned).into()),
        Tests::Slow(filters) => {
            ("share", ["--run-ignored", "only", "-E", &filters.join(" | ")].map(str::to_owned).into())
        }
    };
    let more: Vec<&str> = more.iter().map(String::as_str).collect();
    let report = cargo.folder().join("target/nextest").join(settings).join("junit.xml");
    _ = fs::remove_file(&report);
    cargo
        .run(&[&["nextest", "run", "--profile", settings][..], &base, &more].concat())
        .and(slowest(&report).map(|tests| tests.iter().for_each(|(s, name)| println!("{s:8.1} s {name}"))))
}

/// The output of `cargo nextest list`.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Listed {
    rust_suites: std::collections::BTreeMap<String, Suite>,
}

#[derive(Deserialize)]
struct Suite {
    testcases: std::collections::BTreeMap<String, Case>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Case {
    filter_match: FilterMatch,
}

#[derive(Deserialize)]
struct FilterMatch {
    status: String,
}

/// Lists the slow tests that a push may run, each as a filter of cargo-nextest that matches only this test.
pub(crate) fn slow_tests(cargo: &Cargo<'_>, profile: &str, targets: &[&str]) -> Result<Vec<String>, String> {
    let list = ["nextest", "list", "--profile", "share", "--run-ignored", "only", "--message-format", "json"];
    let text = cargo.output(&[&list[..], &["--cargo-profile", profile], targets].concat())?;
    let listed: Listed = serde_json::from_str(&text).map_err(|e| format!("the list of tests: {e}"))?;
    let of = |(program, suite): (String, Suite)| {
        let tests = suite.testcases.into_iter().filter(|(_, case)| case.filter_match.status == "matches");
        tests.map(move |(test, _)| format!("(binary_id(={program}) & test(={test}))")).collect::<Vec<_>>()
    };
    Ok(listed.rust_suites.into_iter().flat_map(of).collect())
}

/// Reads the slowest tests from a report of cargo-nextest, with their seconds.
fn slowest(report: &Path) -> Result<Vec<(f64, String)>, String> {
    let text = fs::read_to_string(report).map_err(|e| format!("cannot read {}: {e}", report.display()))?;
    let document = roxmltree::Document::parse(&text).map_err(|e| format!("{}: {e}", report.display()))?;
    let cases = document.descendants().filter(|node| node.has_tag_name("testcase"));
    let mut all: Vec<(f64, String)> = cases
        .filter_map(|case| {
            let seconds = case.attribute("time")?.parse().ok()?;
            Some((seconds, format!("{} {}", case.attribute("classname")?, case.attribute("name")?)))
        })
        .collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.truncate(SLOWEST);
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slowest_tests_are_read_from_the_report() {
        let folder = tempfile::tempdir().unwrap();
        let report = folder.path().join("junit.xml");
        let case = |i: usize| format!("<testcase name=\"t{i}\" classname=\"p::q\" time=\"{i}.5\"/>");
        let cases: String = (0..20).map(case).collect();
        fs::write(&report, format!("<testsuites><testsuite name=\"p\">{cases}</testsuite></testsuites>"))
            .unwrap();
        let found = slowest(&report).unwrap();
        assert_eq!(found.len(), SLOWEST);
        assert_eq!(found[0], (19.5, "p::q t19".to_owned()));
        assert!(slowest(&folder.path().join("none.xml")).is_err());
    }
}
