//! What the programs show without a GPU: self-contained pages with tables and pictures, and plots.

#![forbid(unsafe_code)]
// These macros panic if the output cannot be written.
#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod page;
pub mod plot;
