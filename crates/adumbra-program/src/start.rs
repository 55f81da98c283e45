//! The course of a program: it parses its arguments, runs a verb, prints its error if it fails, and ends with an exit
//! code.

use std::process::ExitCode;

use clap::Parser;

use crate::exit::{Code, Outcome};
use crate::{allocator, environment, signals};

/// A program's arguments, and how they are run.
pub trait Program: Parser {
    /// Whether the arguments are only checked. This is how documents are checked whose commands take hours.
    fn checks_arguments_only(&self) -> bool;

    /// Runs the verb that the arguments ask for.
    ///
    /// # Errors
    ///
    /// Returns [`crate::exit::Failure`] if the verb fails. [`main`] prints its text and ends with its code.
    fn run(self) -> Outcome;
}

/// Runs a program: its whole `main`.
pub fn main<P: Program>() -> ExitCode {
    environment::set_runtime_folder();
    allocator::return_large_blocks();
    signals::survive_file_size_limit();
    let program = match P::try_parse() {
        Ok(program) => program,
        Err(error) => {
            let code = if error.use_stderr() { Code::Usage } else { Code::Fine };
            // If even this cannot be printed, nothing is left to do.
            let _ = error.print();
            return code.into();
        }
    };
    if program.checks_arguments_only() {
        return Code::Fine.into();
    }
    match program.run() {
        Ok(code) => code.into(),
        Err(error) => {
            eprintln!("error: {error}");
            error.code().into()
        }
    }
}
