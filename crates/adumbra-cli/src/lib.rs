//! The program `adumbra`: bakes a scene's sun shadows into a file, and verifies the file's answers against
//! rays. A library, so that the package for Python has the program too.

// These macros panic if the stream cannot be written.
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod args;
mod cmd;

use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

use adumbra_program::exit::{Code, Outcome};
use adumbra_program::{signals, start};

use crate::args::{Args, Verb};

impl start::Program for Args {
    fn checks_arguments_only(&self) -> bool {
        self.check_arguments
    }

    fn run(self) -> Outcome {
        // A follower ends only when interrupted, so that counts as success.
        let is_follower = matches!(&self.verb, Verb::Bake(bake) if bake.watch);
        signals::end_when_interrupted(if is_follower { Code::Fine } else { Code::Interrupted });
        cmd::run(self.verb)
    }
}

/// Runs the program in its own process: its whole `main`.
pub fn main() -> ExitCode {
    start::main::<Args>()
}

/// Runs the program in the process of another one, which a person started by the file `program`, and returns
/// the exit code with which that process must end. The words are those after the program's name. Signals that
/// interrupt end the process.
pub fn run(program: &Path, words: impl IntoIterator<Item = OsString>) -> Code {
    start::run_within::<Args>(program, words)
}
