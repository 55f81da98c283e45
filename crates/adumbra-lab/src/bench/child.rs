//! Runs `adumbra` in a process of its own, so that its peak memory is measured separately.

use adumbra::IoError;
use std::ffi::OsStr;
use std::path::Path;
use std::process::{Command, Stdio};

use adumbra_program::exit::Failure;
use serde_json::Value;
use tempfile::NamedTempFile;

use crate::programs::Program;
use adumbra_compare::Result;

/// Creates a temporary shadow file, which is deleted on drop.
pub(super) fn shadow_file() -> Result<NamedTempFile> {
    let file = tempfile::Builder::new().suffix(".adumbra").tempfile();
    Ok(file.map_err(IoError::at("create", std::env::temp_dir()))?)
}

/// Bakes `scene` under the tables' sun, with additional options, into a temporary file. Returns the bake's JSON report.
pub(super) fn bake(scene: &Path, options: &[&str]) -> Result<Value> {
    bake_into(shadow_file()?.path(), scene, &[&["--sun", "0.5,0.8,0.35"], options].concat())
}

/// Bakes `scene` with options into `file`. Returns the bake's JSON report.
pub(super) fn bake_into(file: &Path, scene: &Path, options: &[&str]) -> Result<Value> {
    let start = [OsStr::new("bake"), scene.as_ref(), "-o".as_ref(), file.as_ref(), "--progress".as_ref()];
    json(&[&start, ["none"].map(OsStr::new).as_slice(), &words(options)].concat())
}

/// Compares `file` with rays through `scene` at `samples` points. Returns `verify`'s report whatever the agreement.
pub(super) fn verify(file: &Path, scene: &Path, samples: u64) -> Result<Value> {
    let samples = samples.to_string();
    let options = ["--min-interior", "0", "--samples", &samples];
    let start = [OsStr::new("verify"), file.as_ref(), "--scene".as_ref(), scene.as_ref()];
    json(&[&start[..], &words(&options)].concat())
}

fn words<'a>(options: &[&'a str]) -> Vec<&'a OsStr> {
    options.iter().map(|&o| OsStr::new(o)).collect()
}

/// Runs a verb with `--json` and returns what it prints.
fn json(arguments: &[&OsStr]) -> Result<Value> {
    let program = Program::Product.path()?;
    let mut command = Command::new(&program);
    command.args(arguments).arg("--json").stderr(Stdio::inherit());
    let output = command.output().map_err(IoError::at("run", &program))?;
    if !output.status.success() {
        return Err(Failure::BadInput(format!("adumbra {arguments:?} failed: {}", output.status)).into());
    }
    Ok(serde_json::from_slice(&output.stdout).map_err(|e| Failure::BadInput(e.to_string()))?)
}
