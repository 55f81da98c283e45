//! Stands in for rustdoc where cargo runs the doc tests of a library, and has its documentation made too.
//!
//! `cargo doc` checks every dependency first, which takes minutes where nothing is built. Doc tests use what the tests have
//! built already.

use std::path::Path;
use std::process::{Child, Command, ExitCode};
use std::{env, io};

use crate::steps::{Cargo, PROFILE};

/// Says that this program stands in for rustdoc, and names the folder of the documentation.
const OUTPUT: &str = "ADUMBRA_RUSTDOC";

/// Documents the libraries, with warnings as errors, and runs their doc tests. `target` is the folder of what is built.
pub(crate) fn test(cargo: Cargo<'_>, target: &Path) -> Result<(), String> {
    // Not the path of the process: the build of the tests has replaced that file.
    let program = target.join(PROFILE).join(format!("xtask{}", env::consts::EXE_SUFFIX));
    let output = target.join("doc");
    cargo.with("RUSTDOC", program.to_string_lossy()).with(OUTPUT, output.to_string_lossy()).run(&[
        "test",
        "--doc",
        "--quiet",
        "--profile",
        PROFILE,
        "--workspace",
        "--no-fail-fast",
    ])
}

/// Does rustdoc's work if cargo runs this program in its place. Returns `None` if it is run as itself.
pub(crate) fn stand_in(arguments: &[String]) -> Option<ExitCode> {
    let output = env::var(OUTPUT).ok()?;
    let rustdoc = |arguments: &[String]| Command::new("rustdoc").args(arguments).spawn();
    let passed = |started: io::Result<Child>| {
        started.and_then(|mut process| process.wait()).is_ok_and(|status| status.success())
    };
    // Cargo tests one library after the other; two processes have the work of each.
    let is_test = arguments.iter().any(|argument| argument == "--test");
    let documented = is_test.then(|| rustdoc(&documenting(arguments, &output)));
    let is_tested = passed(rustdoc(arguments));
    let is_fine = documented.is_none_or(passed) && is_tested;
    Some(if is_fine { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Returns the arguments that document what these arguments test.
fn documenting(arguments: &[String], output: &str) -> Vec<String> {
    let mut kept = Vec::new();
    let mut arguments = arguments.iter();
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--test" | "--no-run" => {}
            "--test-run-directory" | "--test-args" => _ = arguments.next(),
            _ => kept.push(argument.clone()),
        }
    }
    kept.extend(["-D", "warnings", "--out-dir", output].map(str::to_owned));
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rustdoc_documents_what_it_tests() {
        let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        let test =
            "--edition=2024 --crate-name a --test a.rs --test-run-directory b --test-args c --extern d";
        let documented = "--edition=2024 --crate-name a a.rs --extern d -D warnings --out-dir o";
        assert_eq!(documenting(&words(test), "o"), words(documented));
    }
}
