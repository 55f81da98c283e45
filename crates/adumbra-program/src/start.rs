//! The life of a program: it parses its arguments, runs a verb, prints its error if it fails, and ends with
//! an exit code.

use std::process::ExitCode;

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

/// Runs a program: its whole `main`. Fails if its output did not reach stdout.
pub fn main<P: Program>() -> ExitCode {
    environment::set_runtime_folder();
    allocator::return_large_blocks();
    signals::survive_file_size_limit();
    let program = match P::try_parse() {
        Ok(program) => program,
        Err(error) => {
            let code = if error.use_stderr() { Code::Usage } else { Code::Fine };
            if let Err(unprinted) = error.print()
                && code == Code::Fine
            {
                console::fail(unprinted);
            }
            return ended(code).into();
        }
    };
    if program.checks_arguments_only() {
        return Code::Fine.into();
    }
    match program.run() {
        Ok(code) => ended(code).into(),
        Err(error) => {
            note!("error: {error}");
            error.code().into()
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
