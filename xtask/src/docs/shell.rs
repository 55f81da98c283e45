//! Runs the documents' commands as a newcomer would, in a copy of the repository.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

use super::Depth;
use super::display::Display;
use super::limit::Limit;
use crate::steps::target_folder;

/// A copy of the files that git would clone, with the programs of the original checkout in `target/release`.
pub(crate) struct Clone {
    /// The checkout.
    root: PathBuf,
    folder: TempDir,
    path: OsString,
    depth: Depth,
    /// The display of documents that open windows.
    display: Option<Display>,
}

/// How a command is run.
#[derive(Debug, PartialEq)]
pub(crate) enum Run {
    /// Run unchanged by the shell.
    Shell(String),
    /// Nothing to run: the file that the command makes or names must already exist.
    Built(String),
    /// Nothing to run: a task of `cargo xtask`, like this check itself.
    Task,
}

impl Clone {
    pub(crate) fn of(root: &Path, depth: Depth) -> io::Result<Self> {
        let folder = tempfile::Builder::new().prefix("adumbra-docs-").tempdir()?;
        let files = Command::new("git")
            .args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"])
            .current_dir(root)
            .output()?;
        let names = String::from_utf8_lossy(&files.stdout);
        // Deleted files that are not committed yet are listed too.
        for name in names.split('\0').filter(|n| !n.is_empty() && root.join(n).is_file()) {
            let to = folder.path().join(name);
            fs::create_dir_all(to.parent().unwrap_or(folder.path()))?;
            fs::copy(root.join(name), to)?;
        }
        fs::create_dir(folder.path().join("target"))?;
        let built = target_folder(root).join(depth.profile());
        link(&built, &folder.path().join("target/release"))?;
        let programs = folder.path().join("target/release");
        let before = env::var_os("PATH").unwrap_or_default();
        let path = env::join_paths([programs].into_iter().chain(env::split_paths(&before)));
        let path = path.map_err(io::Error::other)?;
        Ok(Self { root: root.to_owned(), path, folder, depth, display: None })
    }

    /// Starts a virtual display, on which windows open from now on.
    pub(crate) fn open_display(&mut self) -> io::Result<()> {
        self.display = Display::start()?;
        Ok(())
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Runs a command. A file that should have been built but was not is an error, and so is exceeding the
    /// time limit.
    pub(crate) fn run(&self, command: &str, limit: &Limit) -> Result<Output, String> {
        let done = Output { status: Default::default(), stdout: Vec::new(), stderr: Vec::new() };
        match Run::of(command, &self.root, self.depth != Depth::Full) {
            Run::Task => Ok(done),
            Run::Built(file) if self.folder().join(&file).is_file() => Ok(done),
            Run::Built(file) => Err(format!("{file} is not built")),
            Run::Shell(line) => self.shell(&line, limit).map_err(|e| format!("{line}: {e}")),
        }
    }

    fn shell(&self, line: &str, limit: &Limit) -> io::Result<Output> {
        let mut command = Command::new("sh");
        command.args(["-c", line]).current_dir(self.folder()).env("PATH", &self.path);
        if let Some(display) = &self.display {
            command.env("DISPLAY", display.name()).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        }
        // Unrelated to the documents: Mesa prints an error on stderr if this variable is missing.
        if env::var_os("XDG_RUNTIME_DIR").is_none() {
            command.env("XDG_RUNTIME_DIR", env::temp_dir());
        }
        limit.output(&mut command)
    }
}

impl Run {
    pub(crate) fn of(command: &str, root: &Path, quick: bool) -> Self {
        let words: Vec<&str> = command.split_whitespace().collect();
        match words.as_slice() {
            ["cargo", "xtask", ..] => Self::Task,
            ["alias", name] => Self::Built(name.split_once('=').map_or(*name, |(_, file)| file).to_owned()),
            ["cargo", "build", "--release"] if quick => Self::Built("target/release/adumbra".to_owned()),
            ["cargo", "run", "--release", "--", rest @ ..]
            | ["cargo", "run", "--release", "--no-default-features", "--", rest @ ..]
                if quick =>
            {
                Self::Shell(format!("adumbra {}", rest.join(" ")))
            }
            ["cargo", "run", "--release", "-p", _, "--example", name, rest @ ..] if quick => {
                let arguments = rest.strip_prefix(&["--"]).unwrap_or(rest).join(" ");
                Self::Shell(format!("target/release/examples/{name} {arguments}").trim().to_owned())
            }
            ["cargo", "run", "--release", "-p", "adumbra-lab", "--", rest @ ..] if quick => {
                Self::Shell(format!("adumbra-lab {}", rest.join(" ")))
            }
            // Build in the checkout, whose programs are linked here. Building the sources of the copy would
            // repeat the work and leave the results behind.
            ["cargo", verb @ ("build" | "run"), rest @ ..] => {
                let manifest = root.join("Cargo.toml").display().to_string();
                // The whole program, which later commands need, stays where it is.
                let target = match rest.contains(&"--no-default-features") {
                    true => format!(" --target-dir '{}'", root.join("target/lean").display()),
                    false => String::new(),
                };
                Self::Shell(format!("cargo {verb} --manifest-path '{manifest}'{target} {}", rest.join(" ")))
            }
            _ => Self::Shell(command.to_owned()),
        }
    }
}

#[cfg(unix)]
fn link(from: &Path, to: &PathBuf) -> io::Result<()> {
    std::os::unix::fs::symlink(from, to)
}

#[cfg(not(unix))]
fn link(from: &Path, to: &PathBuf) -> io::Result<()> {
    std::os::windows::fs::symlink_dir(from, to)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quick_runs_use_existing_builds() {
        let root = Path::new("/a checkout");
        let quick = |command: &str| Run::of(command, root, true);
        assert_eq!(quick("cargo xtask test"), Run::Task);
        assert_eq!(
            quick("alias adumbra=target/release/adumbra"),
            Run::Built("target/release/adumbra".to_owned())
        );
        assert_eq!(quick("cargo build --release"), Run::Built("target/release/adumbra".to_owned()));
        for demo in ["cargo run --release -- demo", "cargo run --release --no-default-features -- demo"] {
            assert_eq!(quick(demo), Run::Shell("adumbra demo".to_owned()));
        }
        assert_eq!(
            quick("cargo run --release -p adumbra-lab -- report -o a"),
            Run::Shell("adumbra-lab report -o a".to_owned())
        );
        let example = "cargo run --release -p adumbra-truth --example bake_and_query -- a b";
        assert_eq!(quick(example), Run::Shell("target/release/examples/bake_and_query a b".to_owned()));
        let of_checkout = "cargo run --manifest-path '/a checkout/Cargo.toml' --release -p adumbra-truth --example bake_and_query -- a b";
        assert_eq!(Run::of(example, root, false), Run::Shell(of_checkout.to_owned()));
        let lean = "cargo run --manifest-path '/a checkout/Cargo.toml' --target-dir '/a checkout/target/lean' --release --no-default-features -- demo";
        let demo = "cargo run --release --no-default-features -- demo";
        assert_eq!(Run::of(demo, root, false), Run::Shell(lean.to_owned()));
        assert_eq!(quick("adumbra demo # why"), Run::Shell("adumbra demo # why".to_owned()));
    }
}
