//! Development tasks: `cargo xtask` without a task lists them.

mod api;
#[cfg(test)]
mod arrows;
mod check;
mod docs;
mod engines;
mod python;
mod runner;
mod rustdoc;
mod steps;
mod tiers;
mod tools;

use std::env;
use std::path::Path;
use std::process::ExitCode;

use steps::{Cargo, PROFILE, Steps};

const USAGE: &str = "usage:
  cargo xtask check           formatting, lints, documentation, what the lean program links, each feature alone, the reader for WebAssembly, fuzz targets, licences of dependencies
  cargo xtask test            what each push must pass: formatting, lints, every test that is not marked slow, documentation, the documents
  cargo xtask test --long     what is checked, all tests, instruction counts, and the documents' commands
  cargo xtask test-bevy       formatting, lints and tests of integrations/bevy_adumbra, which builds Bevy; --long: its documentation and examples too
  cargo xtask test-web        types, lints, builds and tests of integrations/three, in Node.js and in a browser; --long: every browser test and the guide
  cargo xtask test-python     formatting, lints, types and tests of the package in python, as an installed wheel; --long: its notebook, farms and remote stores, every version of Python, and wheels for other platforms too
  cargo xtask docs            run every command of README and docs/ in a copy of the repository, check its output; check links
  cargo xtask docs --quick    use existing builds and smaller numbers, only parse the arguments of long commands; FILE... reads only these files
  cargo xtask docs --parse    use existing builds, only parse the arguments of all commands but the README's
  cargo xtask vectors         regenerate test_vectors/
  cargo xtask shaders-web     regenerate the look-ups of integrations/three from the workspace's WGSL
  cargo xtask api             regenerate docs/api.txt and docs/api-bake.txt, the public items of reader and baker
  cargo xtask count           compare instruction counts of the hot steps with docs/counts.json; --bless writes it";

fn main() -> ExitCode {
    let args: Vec<String> = env::args().skip(1).collect();
    if let Some(code) = rustdoc::stand_in(&args) {
        return code;
    }
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."));
    let outcome = match words.as_slice() {
        ["check"] => {
            let mut steps = Steps::default();
            check::run(root, &mut steps);
            steps.finish()
        }
        ["test"] => tiers::push(root),
        ["test", "--long"] => tiers::long(root),
        ["test-bevy"] => engines::bevy(root, false),
        ["test-bevy", "--long"] => engines::bevy(root, true),
        ["test-web"] => engines::web(root, false),
        ["test-web", "--long"] => engines::web(root, true),
        ["test-python"] => python::test(root, false),
        ["test-python", "--long"] => python::test(root, true),
        ["shaders-web"] => Cargo::new(&root.join(engines::GENERATOR)).run(&["run", "--quiet"]),
        ["docs", options @ ..] => {
            tools::ensure_documents().and_then(|()| docs::run(root, options).map_err(|e| e.to_string()))
        }
        ["api"] => write_api(root),
        ["vectors"] => Cargo::linting(root).and_then(|cargo| bakes(&cargo, PROFILE, &words)),
        ["count", ..] => count(root, &words),
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

/// Counts instructions in the release profile, which users run, and not in the profile of the tests.
fn count(root: &Path, words: &[&str]) -> Result<(), String> {
    bakes(&Cargo::new(root), "release", words)
}

/// Runs a task that bakes.
fn bakes(cargo: &Cargo<'_>, profile: &str, words: &[&str]) -> Result<(), String> {
    let program = ["run", "--quiet", "--profile", profile, "--package", "xtask-bakes", "--"];
    cargo.run(&[&program, words].concat())
}

fn write_api(root: &Path) -> Result<(), String> {
    for api in &api::APIS {
        let (text, items) = api::list(root, api)?;
        std::fs::write(root.join(api.list), text).map_err(|e| format!("cannot write {}: {e}", api.list))?;
        println!("{}: {items} items", api.list);
    }
    Ok(())
}
