//! Stdout and stderr. `println!` and `eprintln!` panic if writing fails, as on a full disk.

use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write};
use std::sync::{Mutex, PoisonError};

use adumbra::IoError;

/// The first error of stdout.
static FAILURE: Mutex<Option<io::Error>> = Mutex::new(None);

/// Prints a line on stdout: [`say!`](crate::say).
pub fn say(words: Arguments<'_>) {
    if let Err(error) = writeln!(io::stdout(), "{words}") {
        fail(error);
    }
}

/// Prints a line on stderr: [`note!`](crate::note).
pub fn note(words: Arguments<'_>) {
    let _ = writeln!(io::stderr(), "{words}");
}

/// Keeps an error of stdout. Ignores a closed pipe: its reader, such as `head`, has read enough.
pub(crate) fn fail(error: io::Error) {
    if error.kind() != ErrorKind::BrokenPipe {
        FAILURE.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
}

/// Checks that everything was written to stdout.
///
/// # Errors
///
/// Returns the first [`IoError`], once.
pub(crate) fn check() -> Result<(), IoError> {
    if let Err(error) = io::stdout().flush() {
        fail(error);
    }
    let failure = FAILURE.lock().unwrap_or_else(PoisonError::into_inner).take();
    failure.map_or(Ok(()), |error| Err(IoError::at("write", "the standard output")(error)))
}
