//! Finds the revision of the sources that a program is built from. The build scripts of
//! `adumbra-cli` and `adumbra-lab` include this file. Libraries do not: a library that knew the revision
//! would be compiled again, with everything that depends on it, whenever a source changes.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Files that are part of every program, in addition to the packages.
const SHARED: [&str; 2] = ["Cargo.toml", "Cargo.lock"];
/// Folders of packages.
const FOLDERS: [&str; 2] = ["crates", "lab"];
/// Parts of each package that go into a program.
const OF_PACKAGE: [&str; 5] = ["Cargo.toml", "build.rs", "src", "data", "wgsl"];

/// Sets `ADUMBRA_REVISION` for the package that is being built, empty if git does not know it, and
/// `ADUMBRA_VERSION`, which has both the version and the revision. Packages in the folders `without` are not
/// part of the program.
pub(crate) fn emit(without: &[&str]) {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=revision.rs");
    let folder = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let version = env::var("CARGO_PKG_VERSION").unwrap_or_default();
    let revision = revision(&folder, without).unwrap_or_default();
    println!("cargo::rustc-env=ADUMBRA_REVISION={revision}");
    let long = if revision.is_empty() { version } else { format!("{version} ({revision})") };
    println!("cargo::rustc-env=ADUMBRA_VERSION={long}");
}

fn revision(folder: &Path, without: &[&str]) -> Option<String> {
    let root = folder.ancestors().nth(2)?;
    let within = folder.strip_prefix(root).ok()?.to_str()?;
    // In a registry's cache or a vendor folder, the surrounding repository belongs to another project.
    if !FOLDERS.iter().any(|packages| within.starts_with(&format!("{packages}/"))) {
        return None;
    }
    if git(folder, &["rev-parse", "--show-prefix"])? != format!("{within}/") {
        return None;
    }
    let sources = sources(root, without);
    sources.iter().for_each(|path| watch(&root.join(path)));
    // The log changes with every commit, even if the branch's own file is packed.
    let branch = git(root, &["symbolic-ref", "--quiet", "HEAD"]);
    for name in [Some("HEAD"), Some("logs/HEAD"), branch.as_deref()].into_iter().flatten() {
        watch(&root.join(git(root, &["rev-parse", "--git-path", name])?));
    }
    // Sources that were copied into another repository but not committed there have no revision.
    git(folder, &["ls-files", "--error-unmatch", "build.rs"])?;
    let head = git(root, &["rev-parse", "--short=12", "HEAD"])?;
    let mut changed = vec!["status", "--porcelain", "--untracked-files=no", "--"];
    changed.extend(sources.iter().map(String::as_str));
    let changed = git(root, &changed)?;
    Some(if changed.is_empty() { head } else { format!("{head}-dirty") })
}

/// Returns the paths of everything that goes into the program, relative to the root.
fn sources(root: &Path, without: &[&str]) -> Vec<String> {
    let mut sources: Vec<String> = SHARED.map(str::to_owned).into();
    for folder in FOLDERS {
        let packages = fs::read_dir(root.join(folder)).into_iter().flatten().flatten();
        let names = packages.map(|p| p.file_name().to_string_lossy().into_owned());
        for package in names.filter(|name| !without.contains(&name.as_str())) {
            sources.extend(OF_PACKAGE.map(|part| format!("{folder}/{package}/{part}")));
        }
    }
    sources
}

/// Makes the build script run again when a file changes. A file that does not exist would make it run every
/// time.
fn watch(path: &Path) {
    if path.exists() {
        println!("cargo::rerun-if-changed={}", path.display());
    }
}

/// Returns git's output in `folder`, regardless of the repository that the caller works in. `None` if git
/// fails.
fn git(folder: &Path, arguments: &[&str]) -> Option<String> {
    let mut command = Command::new("git");
    command.arg("-C").arg(folder).args(arguments).env("GIT_OPTIONAL_LOCKS", "0");
    for name in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_COMMON_DIR", "GIT_PREFIX"] {
        command.env_remove(name);
    }
    let output = command.output().ok().filter(|o| o.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
