//! Runs `adumbra`, or this program, in a separate process, so that its peak memory is measured separately.

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

/// The sun of the tables.
const SUN: [&str; 2] = ["--sun", "0.5,0.8,0.35"];

/// Bakes `scene` under the tables' sun, with additional options, into a temporary file. Returns the bake's
/// JSON report.
pub(super) fn bake(scene: &Path, options: &[&str]) -> Result<Value> {
    bake_into(shadow_file()?.path(), scene, &[&SUN, options].concat())
}

/// Bakes `scene` with options into `file`. Returns the bake's JSON report.
pub(super) fn bake_into(file: &Path, scene: &Path, options: &[&str]) -> Result<Value> {
    json(Program::Product, &[&words(&["bake"])[..], &baking(file, scene), &words(options)].concat())
}

/// Bakes `scene` under the tables' sun, with additional options, into a temporary tree. Returns the bake's
/// JSON report.
pub(super) fn bake_tree(scene: &Path, options: &[&str]) -> Result<Value> {
    let file = shadow_file()?;
    let bake = words(&["tree", "bake"]);
    json(
        Program::Laboratory,
        &[&bake[..], &baking(file.path(), scene), &words(&SUN), &words(options)].concat(),
    )
}

/// The arguments of every bake of `scene` into `file`.
fn baking<'a>(file: &'a Path, scene: &'a Path) -> [&'a OsStr; 5] {
    [scene.as_ref(), "-o".as_ref(), file.as_ref(), "--progress".as_ref(), "none".as_ref()]
}

/// Compares `file` with rays through `scene` at `samples` points. Returns the report of `verify` even if a
/// check fails.
pub(super) fn verify(file: &Path, scene: &Path, samples: u64) -> Result<Value> {
    let samples = samples.to_string();
    let options = ["--min-interior", "0", "--samples", &samples];
    let start = [OsStr::new("verify"), file.as_ref(), "--scene".as_ref(), scene.as_ref()];
    json(Program::Product, &[&start[..], &words(&options)].concat())
}

fn words<'a>(options: &[&'a str]) -> Vec<&'a OsStr> {
    options.iter().map(|&o| OsStr::new(o)).collect()
}

/// Runs a verb with `--json` and returns what it prints.
fn json(program: Program, arguments: &[&OsStr]) -> Result<Value> {
    let path = program.path()?;
    let mut command = Command::new(&path);
    command.args(arguments).arg("--json").stderr(Stdio::inherit());
    let output = command.output().map_err(IoError::at("run", &path))?;
    if !output.status.success() {
        let (name, status) = (program.name(), output.status);
        return Err(Failure::BadInput(format!("{name} {arguments:?} failed: {status}")).into());
    }
    Ok(serde_json::from_slice(&output.stdout).map_err(|e| Failure::BadInput(e.to_string()))?)
}
