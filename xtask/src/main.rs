//! Development tasks: `cargo xtask test [--quick]`, `cargo xtask docs [--quick]`, `cargo xtask vectors`,
//! `cargo xtask count [--bless]`, `cargo xtask tune-ao`.

mod broken;
mod count;
mod docs;
mod tools;
mod tree_vectors;
mod tune_ao;
mod vectors;

use std::env;
use std::path::Path;
use std::process::{Command, ExitCode};

const USAGE: &str = "usage:
  cargo xtask test            formatting, lints, documentation, every test, the documents' commands
  cargo xtask test --quick    without real scenes and what bakes over and over, under two minutes
  cargo xtask docs            every command of README and docs/ in a copy of the repository, its output checked; links
  cargo xtask docs --quick    with what is built, smaller numbers, and only the arguments of what takes long; FILE... reads these alone
  cargo xtask vectors         write test_vectors/ again
  cargo xtask count           instructions of the hot steps beside docs/counts.json; --bless writes it
  cargo xtask tune-ao [--scenes DIR] [--budget N] [--only NAME,...]
                              look for the estimators' parameters of ambient occlusion on the eight scenes; DIR is where the tests
                              find scenes, N 120, and NAME every estimator if not given
  cargo xtask tune-ao --variant NAME:KEY=VALUE... [--variant ...]
                              the same with parameters fixed that have words or no search; prints, records nothing";

fn main() -> ExitCode {
    let args: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."));
    let outcome = match words.as_slice() {
        ["test"] => test(root),
        ["test", "--quick"] => quick_test(root),
        ["docs", options @ ..] => {
            tools::ensure_documents().and_then(|()| docs::run(root, options).map_err(|e| e.to_string()))
        }
        ["vectors"] => vectors::run(root).map_err(|e| e.to_string()),
        ["count", options @ ..] => count::run(root, options).map_err(|e| e.to_string()),
        ["tune-ao", options @ ..] => {
            tools::ensure_driver().and_then(|()| tune_ao::run(root, options).map_err(|e| e.to_string()))
        }
        _ => Err(USAGE.to_owned()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn test(root: &Path) -> Result<(), String> {
    for component in ["rustfmt", "clippy"] {
        let found = Command::new("cargo").args([component_verb(component), "--version"]).output();
        if !found.is_ok_and(|o| o.status.success()) {
            return Err(format!("{component} is missing; install it with: rustup component add {component}"));
        }
    }
    cargo(root, &["fmt", "--all", "--check"], &[])?;
    cargo(root, &["clippy", "--release", "--workspace", "--all-targets", "--", "-D", "warnings"], &[])?;
    cargo(root, &["doc", "--release", "--workspace", "--no-deps"], &[("RUSTDOCFLAGS", "-D warnings")])?;
    tools::ensure_all()?;
    cargo(root, &["test", "--release", "--workspace", "--no-fail-fast"], &[("ADUMBRA_REQUIRE_TOOLS", "1")])?;
    docs::run(root, &["--quick"]).map_err(|e| e.to_string())
}

/// How tests are named that a quick run leaves out: those of real scenes, those that bake, bench or count over and over, and
/// scene fuzzing at full length.
const NOT_QUICK: [&str; 15] = [
    "shared_",
    "bench_",
    "counts_the_taps_that_the_cpu_counts",
    "demo_",
    "a_stray_triangle_",
    "ground_of_any_width_",
    "a_town_at_map_coordinates_",
    "view_bakes_anew_",
    "limited_bake_",
    "bake_writes_the_same_bytes_",
    "report_browser_",
    "report_keeps_what_was_measured_",
    "report_leaves_what_there_is_",
    "report_says_that_its_page_",
    "fuzz_scenes_full",
];

fn quick_test(root: &Path) -> Result<(), String> {
    tools::ensure_driver()?;
    let mut args = vec!["test", "--release", "--workspace", "--"];
    args.extend(NOT_QUICK.iter().flat_map(|name| ["--skip", name]));
    cargo(root, &args, &[])
}

fn component_verb(component: &str) -> &str {
    if component == "rustfmt" { "fmt" } else { component }
}

fn cargo(root: &Path, args: &[&str], environment: &[(&str, &str)]) -> Result<(), String> {
    eprintln!("cargo {}", args.join(" "));
    let status = Command::new("cargo")
        .args(args)
        .envs(environment.iter().copied())
        .current_dir(root)
        .status()
        .map_err(|e| format!("cannot run cargo: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("cargo {} failed", args.join(" "))) }
}
