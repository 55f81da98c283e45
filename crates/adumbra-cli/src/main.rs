//! The program `adumbra`.

use std::process::ExitCode;

fn main() -> ExitCode {
    adumbra_cli::main()
}
