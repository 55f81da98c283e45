//! Bakes in a process of their own, so that their memory is their own.

use std::path::Path;
use std::process::{Command, Stdio};

use adumbra::Error;
use serde_json::Value;

use crate::exit::Failure;

/// Bakes `scene` under the tables' sun with more options into a file that goes away; gives what the bake says of itself.
pub(super) fn bake(scene: &Path, options: &[&str]) -> Result<Value, Failure> {
    let program = std::env::current_exe().map_err(Error::io("find", "this program"))?;
    let file = tempfile::Builder::new()
        .suffix(".adumbra")
        .tempfile()
        .map_err(Error::io("create", std::env::temp_dir()))?;
    let mut command = Command::new(&program);
    command.arg("bake").arg(scene).arg("-o").arg(file.path());
    command.args(["--sun", "0.5,0.8,0.35", "--progress", "none", "--json"]).args(options);
    let output = command.stderr(Stdio::inherit()).output().map_err(Error::io("run", &program))?;
    if !output.status.success() {
        let what = format!("the bake of {} with {options:?} failed: {}", scene.display(), output.status);
        return Err(Failure::BadInput(what));
    }
    serde_json::from_slice(&output.stdout).map_err(|e| Failure::BadInput(e.to_string()))
}
