//! The program in a process of its own, so that its memory is its own.

use std::ffi::OsStr;
use std::path::Path;
use std::process::{Command, Stdio};

use adumbra::Error;
use serde_json::Value;
use tempfile::NamedTempFile;

use crate::exit::Failure;

/// A shadow file that goes away.
pub(super) fn shadow_file() -> Result<NamedTempFile, Failure> {
    let file = tempfile::Builder::new().suffix(".adumbra").tempfile();
    Ok(file.map_err(Error::io("create", std::env::temp_dir()))?)
}

/// Bakes `scene` under the tables' sun with more options into a file that goes away; gives what the bake says of itself.
pub(super) fn bake(scene: &Path, options: &[&str]) -> Result<Value, Failure> {
    bake_into(shadow_file()?.path(), scene, &[&["--sun", "0.5,0.8,0.35"], options].concat())
}

/// Bakes `scene` with options into `file`; gives what the bake says of itself.
pub(super) fn bake_into(file: &Path, scene: &Path, options: &[&str]) -> Result<Value, Failure> {
    let start = [OsStr::new("bake"), scene.as_ref(), "-o".as_ref(), file.as_ref(), "--progress".as_ref()];
    json(&[&start, ["none"].map(OsStr::new).as_slice(), &words(options)].concat())
}

/// Compares `file` with rays through `scene` at so many points; gives what `verify` says, whatever it finds.
pub(super) fn verify(file: &Path, scene: &Path, samples: u64) -> Result<Value, Failure> {
    let samples = samples.to_string();
    let options = ["--min-interior", "0", "--samples", &samples];
    let start = [OsStr::new("verify"), file.as_ref(), "--scene".as_ref(), scene.as_ref()];
    json(&[&start[..], &words(&options)].concat())
}

fn words<'a>(options: &[&'a str]) -> Vec<&'a OsStr> {
    options.iter().map(|&o| OsStr::new(o)).collect()
}

/// What a verb prints with `--json`.
fn json(arguments: &[&OsStr]) -> Result<Value, Failure> {
    let program = std::env::current_exe().map_err(Error::io("find", "this program"))?;
    let mut command = Command::new(&program);
    command.args(arguments).arg("--json").stderr(Stdio::inherit());
    let output = command.output().map_err(Error::io("run", &program))?;
    if !output.status.success() {
        return Err(Failure::BadInput(format!("adumbra {arguments:?} failed: {}", output.status)));
    }
    serde_json::from_slice(&output.stdout).map_err(|e| Failure::BadInput(e.to_string()))
}
