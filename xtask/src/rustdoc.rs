//! Replaces rustdoc when cargo runs the doc tests of a library, and also builds the library's documentation.
//!
//! `cargo doc` checks every dependency first, which takes minutes in an empty target folder. Doc tests use
//! the existing builds of the tests.

use std::path::Path;
use std::process::{Child, Command, ExitCode};
use std::{env, io};

use crate::steps::{Cargo, PROFILE};

/// Environment variable that makes this program replace rustdoc. Its value is the folder of the
/// documentation.
const OUTPUT: &str = "ADUMBRA_RUSTDOC";

/// Documents the libraries, with warnings as errors, and runs their doc tests. `target` is the build folder.
pub(crate) fn test(cargo: Cargo<'_>, target: &Path) -> Result<(), String> {
    // Do not use the path of the process: the build of the tests has replaced that file.
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

/// Does rustdoc's work if cargo runs this program in its place. Returns `None` otherwise.
pub(crate) fn stand_in(arguments: &[String]) -> Option<ExitCode> {
    let output = env::var(OUTPUT).ok()?;
    let rustdoc = |arguments: &[String]| Command::new("rustdoc").args(arguments).spawn();
    let passed = |started: io::Result<Child>| {
        started.and_then(|mut process| process.wait()).is_ok_and(|status| status.success())
    };
    // Cargo tests one library after the other. Document and test each library in two parallel processes.
    let is_test = arguments.iter().any(|argument| argument == "--test");
    let documented = is_test.then(|| rustdoc(&documenting(arguments, &output)));
    let is_tested = passed(rustdoc(arguments));
    let is_fine = documented.is_none_or(passed) && is_tested;
    Some(if is_fine { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Converts arguments that test a library to arguments that document it.
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
    fn documenting_replaces_test_arguments() {
        let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        let test =
            "--edition=2024 --crate-name a --test a.rs --test-run-directory b --test-args c --extern d";
        let documented = "--edition=2024 --crate-name a a.rs --extern d -D warnings --out-dir o";
        assert_eq!(documenting(&words(test), "o"), words(documented));
    }
}
