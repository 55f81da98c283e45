//! Gives the program the revision of the sources that it is built from, as `ADUMBRA_REVISION`; empty where git does not know.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Where this package lies in the repository, as git says it.
const PLACE: &str = "crates/adumbra-cli/";
/// What else in the repository goes into the program, beside the packages.
const SHARED: [&str; 3] = ["Cargo.toml", "Cargo.lock", "data"];
/// And of each package.
const OF_PACKAGE: [&str; 5] = ["Cargo.toml", "build.rs", "src", "data", "wgsl"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let folder = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    println!("cargo::rustc-env=ADUMBRA_REVISION={}", revision(&folder).unwrap_or_default());
}

fn revision(folder: &Path) -> Option<String> {
    // In a registry's or a vendor's folder the repository around is somebody else's.
    if git(folder, &["rev-parse", "--show-prefix"])? != PLACE {
        return None;
    }
    let root = folder.ancestors().nth(2)?;
    let sources = sources(root);
    sources.iter().for_each(|path| watch(&root.join(path)));
    // The log changes with every commit, also where a branch's own file is packed away.
    let branch = git(root, &["symbolic-ref", "--quiet", "HEAD"]);
    for name in [Some("HEAD"), Some("logs/HEAD"), branch.as_deref()].into_iter().flatten() {
        watch(&root.join(git(root, &["rev-parse", "--git-path", name])?));
    }
    // Sources that are laid into another repository and not committed there are not its own.
    git(folder, &["ls-files", "--error-unmatch", "build.rs"])?;
    let head = git(root, &["rev-parse", "--short=12", "HEAD"])?;
    let mut changed = vec!["status", "--porcelain", "--untracked-files=no", "--"];
    changed.extend(sources.iter().map(String::as_str));
    let changed = git(root, &changed)?;
    Some(if changed.is_empty() { head } else { format!("{head}-dirty") })
}

/// All that goes into the program, below the root.
fn sources(root: &Path) -> Vec<String> {
    let mut sources: Vec<String> = SHARED.map(str::to_owned).into();
    let packages = fs::read_dir(root.join("crates")).into_iter().flatten().flatten();
    for package in packages.map(|p| p.file_name().to_string_lossy().into_owned()) {
        sources.extend(OF_PACKAGE.map(|part| format!("crates/{package}/{part}")));
    }
    sources
}

/// Has this run again when a file changes. One that is not there would have it run each time.
fn watch(path: &Path) {
    if path.exists() {
        println!("cargo::rerun-if-changed={}", path.display());
    }
}

/// What git says in a folder, whatever repository its caller is at work in.
fn git(folder: &Path, arguments: &[&str]) -> Option<String> {
    let mut command = Command::new("git");
    command.arg("-C").arg(folder).args(arguments).env("GIT_OPTIONAL_LOCKS", "0");
    for name in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_COMMON_DIR", "GIT_PREFIX"] {
        command.env_remove(name);
    }
    let output = command.output().ok().filter(|o| o.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
