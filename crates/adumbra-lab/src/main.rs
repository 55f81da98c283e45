//! The program `adumbra-lab`: measures what `adumbra` bakes and draws, and writes the report.

use std::process::ExitCode;

use adumbra_lab::args::{BenchVerb, Report, TuneAo};
use adumbra_lab::{bench, paper_report, programs, tune_ao};
use adumbra_program::exit::Outcome;
use adumbra_program::{signals, start};
use clap::{Parser, Subcommand};

/// Measures what adumbra bakes and draws, compares it with ray-traced truth and with published results, and writes
/// tables and a report.
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

#[derive(Subcommand)]
enum Verb {
    /// Run a benchmark and write its results as tables: bakes, trees, shadows compared with ray-traced truth, and more
    #[command(after_help = "Example: adumbra-lab bench bake --scenes scenes -o docs/bench")]
    Bench {
        #[command(subcommand)]
        what: BenchVerb,
    },
    /// Repeat the measurements of every paper, and write one page that shows the published results next to ours; exit
    /// code 1 if a section failed
    #[command(
        after_help = "Writes report.html, which needs no other file and no network, and report.json. Finished measurements stay in the folder \
        even if a later one fails.\n\n\
        Example: adumbra-lab report -o report\n\nExample: adumbra-lab report --full --scenes scenes --truth truth -o report"
    )]
    Report(Report),
    /// Search for the best parameters of every ambient-occlusion estimator on the eight scenes, and record them
    #[command(
        after_help = "Run it in the repository root: the record that it writes is compiled into the program.\n\n\
        Example: adumbra-lab tune-ao --scenes scenes --only issao\n\n\
        Example: adumbra-lab tune-ao --scenes scenes --variant issao:reading=1 --variant issao:reading=2"
    )]
    TuneAo(TuneAo),
}

impl start::Program for Args {
    fn checks_arguments_only(&self) -> bool {
        self.check_arguments
    }

    fn run(self) -> Outcome {
        if !matches!(self.verb, Verb::Report(_)) {
            signals::end_when_interrupted();
        }
        Ok(match self.verb {
            Verb::Bench { what } => bench::run(&what)?,
            Verb::Report(args) => paper_report::run(&args)?,
            Verb::TuneAo(args) => tune_ao::run(&args)?,
        })
    }
}

fn main() -> ExitCode {
    start::main::<Args>()
}
