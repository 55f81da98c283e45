//! The program `adumbra`: bakes a scene's sun shadows into a file, and verifies the file's answers against rays.

mod args;
mod cmd;

use std::process::ExitCode;

use adumbra_program::exit::Outcome;
use adumbra_program::{signals, start};

use crate::args::{Args, Verb};

impl start::Program for Args {
    fn checks_arguments_only(&self) -> bool {
        self.check_arguments
    }

    fn run(self) -> Outcome {
        if !self.verb.has_something_to_finish() {
            signals::end_when_interrupted();
        }
        cmd::run(self.verb)
    }
}

impl Verb {
    /// Whether the verb handles an interrupt itself.
    fn has_something_to_finish(&self) -> bool {
        match self {
            Self::Bake(_) | Self::Tile(_) | Self::Link(_) | Self::SunHours(_) | Self::Sky(_) => true,
            #[cfg(feature = "render")]
            Self::Demo(_) => true,
            _ => false,
        }
    }
}

fn main() -> ExitCode {
    start::main::<Args>()
}
