//! The program `adumbra-lab`: measures what `adumbra` bakes and draws, and writes the report.

// The print macros panic if output cannot be written.
#![deny(clippy::print_stdout, clippy::print_stderr)]

use std::process::ExitCode;

use adumbra_compare::verbs::{Offer, compare, render};
use adumbra_lab::args::Verb;
use adumbra_lab::{TECHNIQUES, bench, dag, paper_report, programs, schemas, tree, tune_ao};
use adumbra_program::exit::Code;
use adumbra_program::exit::Outcome;
use adumbra_program::{signals, start};
use clap::Parser;

/// Measures what adumbra bakes and draws, compares it with ray-traced truth and with published results, and
/// writes tables and a report.
///
/// Some verbs run the program adumbra, which must be in the same folder.
#[derive(Parser)]
#[command(
    name = "adumbra-lab",
    version = programs::VERSION,
    max_term_width = 110,
    after_help = "Exit codes: 0 success, 1 a check failed, 2 wrong usage, 3 bad input, 4 out of memory or disk, 5 GPU device lost, 130 interrupted."
)]
struct Args {
    #[command(subcommand)]
    verb: Verb,
    /// Exit after parsing the arguments; for checking documents whose commands take hours
    #[arg(long, global = true, hide = true)]
    check_arguments: bool,
}

impl start::Program for Args {
    fn checks_arguments_only(&self) -> bool {
        self.check_arguments
    }

    fn run(self) -> Outcome {
        // A report handles interrupts itself, to keep its finished measurements.
        if !matches!(self.verb, Verb::Report(_)) {
            signals::end_when_interrupted(Code::Interrupted);
        }
        Ok(match self.verb {
            Verb::Bench { what } => bench::run(&what)?,
            Verb::Report(args) => paper_report::run(&args)?,
            Verb::TuneAo(args) => tune_ao::run(&args)?,
            Verb::Dag { what } => dag::run(&what)?,
            Verb::Tree { what } => tree::run(&what)?,
            Verb::Schema(args) => schemas::run(&args)?,
            Verb::Compare(args) => {
                let more_files = || Some(args.cube.more_files());
                let offer = Offer { techniques: TECHNIQUES, more_files: &more_files };
                compare::run(&args.compare, offer)?
            }
            Verb::Render(args) => {
                let more_files = || Some(args.cube.more_files());
                let offer = Offer { techniques: TECHNIQUES, more_files: &more_files };
                render::run(&args.render, offer)?
            }
        })
    }
}

fn main() -> ExitCode {
    start::main::<Args>()
}
