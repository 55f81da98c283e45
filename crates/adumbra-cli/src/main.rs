//! The program `adumbra`: bakes a scene's sun shadows into a file, and proves the file's answers against rays.

/// Prints a line on stdout; a reader that has gone away, or a full disk there, does not end the work.
macro_rules! say {
    ($($words:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($words)*);
    }};
}

mod args;
mod cmd;
mod exit;
mod memory;
mod output;
mod plot;
mod progress;
mod signals;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    signals::survive_file_size_limit();
    let args = match args::Args::try_parse() {
        Ok(args) => args,
        Err(error) => {
            let code = if error.use_stderr() { exit::Code::Usage } else { exit::Code::Fine };
            // Nothing is left to do where not even this can be printed.
            let _ = error.print();
            return code.into();
        }
    };
    if args.check_arguments {
        return exit::Code::Fine.into();
    }
    match cmd::run(args) {
        Ok(code) => code.into(),
        Err(error) => {
            eprintln!("error: {error}");
            error.code().into()
        }
    }
}
