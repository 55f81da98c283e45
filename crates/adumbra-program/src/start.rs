//! The life of a program: it parses its arguments, runs a verb, prints its error if it fails, and ends with
//! an exit code.

use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf, absolute};
use std::process::ExitCode;
use std::sync::OnceLock;

use clap::Parser;

use crate::exit::{Code, Failure, Outcome};
use crate::{allocator, console, environment, note, signals};

/// A program's arguments, and how they are run.
pub trait Program: Parser {
    /// Whether the arguments are only checked. Tests of documents use this for commands that take hours.
    fn checks_arguments_only(&self) -> bool;

    /// Runs the verb that the arguments ask for.
    ///
    /// # Errors
    ///
    /// Returns [`crate::exit::Failure`] if the verb fails. [`main`] prints its text and ends with its code.
    fn run(self) -> Outcome;
}

/// The file that a person runs to run this program, if that is not the process's own.
static STARTED_AS: OnceLock<PathBuf> = OnceLock::new();

/// Returns the absolute path of the file that runs this program again.
///
/// # Errors
///
/// Returns the error of the operating system, if it does not know.
pub fn program_file() -> io::Result<PathBuf> {
    STARTED_AS.get().map_or_else(std::env::current_exe, absolute)
}

/// Runs a program: its whole `main`. Fails if its output did not reach stdout.
pub fn main<P: Program>() -> ExitCode {
    environment::set_runtime_folder();
    run::<P>(std::env::args_os()).into()
}

/// Runs a program as [`main`] does, in the process of another one, which a person started by the file
/// `program`. The process then has to end with the code.
pub fn run_within<P: Program>(program: &Path, words: impl IntoIterator<Item = OsString>) -> Code {
    STARTED_AS.get_or_init(|| program.to_owned());
    run::<P>(std::iter::once(P::command().get_name().into()).chain(words))
}

/// Runs a program with these words, of which the first is its name.
fn run<P: Program>(words: impl IntoIterator<Item = OsString>) -> Code {
    allocator::return_large_blocks();
    signals::survive_file_size_limit();
    let program = match P::try_parse_from(words) {
        Ok(program) => program,
        Err(error) => {
            let code = if error.use_stderr() { Code::Usage } else { Code::Fine };
            if let Err(unprinted) = error.print()
                && code == Code::Fine
            {
                console::fail(unprinted);
            }
            return ended(code);
        }
    };
    if program.checks_arguments_only() {
        return Code::Fine;
    }
    match program.run() {
        Ok(code) => ended(code),
        Err(error) => {
            note!("error: {error}");
            error.code()
        }
    }
}

/// Returns the exit code of a program that has done its work. Its output may not have reached stdout.
fn ended(code: Code) -> Code {
    let Err(error) = console::check() else { return code };
    let failure = Failure::from(error);
    note!("error: {failure}");
    if code == Code::Fine { failure.code() } else { code }
}
