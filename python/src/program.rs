//! The program `adumbra`.

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;

/// Runs the program, which a person started by the file `program`, and returns its exit code.
#[pyfunction]
pub(crate) fn run_program(py: Python<'_>, program: PathBuf, words: Vec<OsString>) -> u8 {
    py.detach(|| adumbra_cli::run(&program, words)) as u8
}
