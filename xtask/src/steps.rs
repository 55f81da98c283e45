//! Steps of a task: commands, their output, and their duration.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// The profile of everything that tests run.
pub(crate) const PROFILE: &str = "ci";

/// The arguments `-D warnings` as `cargo clippy` hands them to clippy's compiler.
const DENY_WARNINGS: &str = "-D__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__";

/// Steps that are run one after the other. A step that fails does not keep the next from running, so that one
/// run shows every fault.
#[derive(Default)]
pub(crate) struct Steps {
    failed: Vec<String>,
}

impl Steps {
    /// Runs a step and prints its seconds. Returns whether it passed.
    pub(crate) fn run(&mut self, name: &str, step: impl FnOnce() -> Result<(), String>) -> bool {
        let start = Instant::now();
        let outcome = step();
        println!("step {name} {}", start.elapsed().as_secs());
        if let Err(fault) = &outcome {
            eprintln!("{fault}");
            self.failed.push(name.to_owned());
        }
        outcome.is_ok()
    }

    /// Returns an error that names the steps that failed.
    pub(crate) fn finish(self) -> Result<(), String> {
        if self.failed.is_empty() { Ok(()) } else { Err(format!("failed: {}", self.failed.join(", "))) }
    }
}

/// Cargo in a folder.
pub(crate) struct Cargo<'a> {
    folder: &'a Path,
    variables: Vec<(&'static str, String)>,
}

impl<'a> Cargo<'a> {
    pub(crate) fn new(folder: &'a Path) -> Self {
        Self { folder, variables: Vec::new() }
    }

    /// Builds the packages of the folder with clippy's compiler, which also lints them, with warnings as
    /// errors. `cargo clippy` would first check every dependency, and cargo would compile it again for the
    /// tests.
    pub(crate) fn linting(folder: &'a Path) -> Result<Self, String> {
        let sysroot = Command::new("rustc").args(["--print", "sysroot"]).output();
        let sysroot = sysroot.map_err(|e| format!("cannot run rustc: {e}"))?.stdout;
        let name = if cfg!(windows) { "clippy-driver.exe" } else { "clippy-driver" };
        let driver = Path::new(String::from_utf8_lossy(&sysroot).trim()).join("bin").join(name);
        if !driver.exists() {
            return Err("clippy is missing; install it with: rustup component add clippy".to_owned());
        }
        let driver = driver.display().to_string();
        Ok(Self::new(folder).with("RUSTC_WORKSPACE_WRAPPER", driver).with("CLIPPY_ARGS", DENY_WARNINGS))
    }

    pub(crate) fn with(mut self, name: &'static str, value: impl Into<String>) -> Self {
        self.variables.push((name, value.into()));
        self
    }

    pub(crate) fn run(&self, arguments: &[&str]) -> Result<(), String> {
        run(self.folder, "cargo", arguments, &self.variables())
    }

    /// The environment variables for a program that runs Cargo.
    pub(crate) fn variables(&self) -> Vec<(&str, &str)> {
        self.variables.iter().map(|(name, value)| (*name, value.as_str())).collect()
    }

    /// Returns what a command prints.
    pub(crate) fn output(&self, arguments: &[&str]) -> Result<String, String> {
        let mut cargo = Command::new("cargo");
        cargo.envs(self.variables.iter().map(|(n, v)| (n, v)));
        printed(&mut cargo, self.folder, arguments)
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder
    }
}

/// Runs a command in a folder and returns its output.
pub(crate) fn output(folder: &Path, program: &str, arguments: &[&str]) -> Result<String, String> {
    printed(&mut Command::new(program), folder, arguments)
}

fn printed(command: &mut Command, folder: &Path, arguments: &[&str]) -> Result<String, String> {
    let program = command.get_program().to_string_lossy().into_owned();
    let output = outside_cargo(command).args(arguments).current_dir(folder).output();
    let output = output.map_err(|e| format!("cannot run {program}: {e}"))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    Err(format!("{program} {} failed\n{}", arguments.join(" "), String::from_utf8_lossy(&output.stderr)))
}

/// Runs a command in a folder, with more environment variables.
pub(crate) fn run(
    folder: &Path,
    program: &str,
    arguments: &[&str],
    variables: &[(&str, &str)],
) -> Result<(), String> {
    let line = format!("{program} {}", arguments.join(" "));
    eprintln!("> {line}");
    let status = outside_cargo(&mut Command::new(program))
        .args(arguments)
        .envs(variables.iter().copied())
        .current_dir(folder)
        .status()
        .map_err(|e| format!("cannot run {program}: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("{line} failed")) }
}

/// Removes the environment variables that `cargo run` sets for this package. Build scripts that depend on
/// them would run again after each switch between `cargo xtask` and `cargo`.
pub(crate) fn outside_cargo(command: &mut Command) -> &mut Command {
    let is_of_package = |name: &str| name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_");
    for (name, _) in env::vars().filter(|(name, _)| is_of_package(name)) {
        command.env_remove(name);
    }
    command
}

/// Returns the build folder.
pub(crate) fn target_folder(root: &Path) -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), |folder| root.join(folder))
}
