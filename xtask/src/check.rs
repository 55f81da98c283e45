//! Checks that run no tests.

use std::collections::BTreeSet;
use std::path::Path;

use crate::steps::{self, Cargo, PROFILE, Steps};

/// Checks formatting, lints, documentation, the crates that the lean program links, each crate alone, the
/// fuzz targets, and the dependencies of all packages.
pub(crate) fn run(root: &Path, steps: &mut Steps) {
    steps.run("format", || format(root));
    let clippy = ["clippy", "--quiet", "--profile", PROFILE];
    let lint = |of: &[&str]| Cargo::new(root).run(&[&clippy[..], of, &["--", "-D", "warnings"]].concat());
    steps.run("lints", || lint(&["--workspace", "--all-targets"]));
    steps.run("documentation", || {
        let doc = ["doc", "--quiet", "--profile", PROFILE, "--workspace", "--no-deps"];
        Cargo::new(root).with("RUSTDOCFLAGS", "-D warnings").run(&doc)
    });
    steps.run("lean program", || {
        lint(&LEAN_PROGRAM)?;
        lean_program(root)
    });
    steps.run("crates alone", || crates_alone(root));
    steps.run("fuzz targets", || {
        Cargo::new(&root.join("fuzz")).with("RUSTFLAGS", "-D warnings").run(&["check", "--quiet", "--locked"])
    });
    steps.run("dependencies", || dependencies(root));
}

pub(crate) fn format(root: &Path) -> Result<(), String> {
    Cargo::new(root).run(&["fmt", "--all", "--check"])
}

/// The folders with their own `Cargo.lock`.
const LOCKED: [&str; 5] =
    [".", "fuzz", "integrations/bevy_adumbra", "integrations/three/generator", "python"];

/// Checks licences, bans and sources of all dependencies with cargo-deny. Advisories change from day to day,
/// so they are not checked.
fn dependencies(root: &Path) -> Result<(), String> {
    let config = root.join("deny.toml").display().to_string();
    let check = ["deny", "--log-level", "error", "--config", &config, "check", "bans", "licenses", "sources"];
    if steps::output(root, "cargo", &["deny", "--version"]).is_err() {
        return Err("cargo-deny is missing; install it with: cargo install --locked cargo-deny".to_owned());
    }
    LOCKED.iter().try_for_each(|folder| Cargo::new(&root.join(folder)).run(&check))
}

/// The program without its features.
const LEAN_PROGRAM: [&str; 3] = ["-p", "adumbra-cli", "--no-default-features"];

/// Checks each crate with only the features that it requests itself. In a build of the whole workspace, cargo
/// also enables the features that other crates request.
fn crates_alone(root: &Path) -> Result<(), String> {
    let names = Cargo::new(root).output(&[
        "tree",
        "--workspace",
        "--depth",
        "0",
        "--prefix",
        "none",
        "--format",
        "{p}",
    ])?;
    let names: BTreeSet<&str> =
        names.lines().filter_map(|line| line.split(' ').next()).filter(|name| !name.is_empty()).collect();
    if !names.contains("adumbra-program") {
        return Err("cargo tree does not list the crates of the workspace".to_owned());
    }
    names
        .into_iter()
        .try_for_each(|name| Cargo::new(root).run(&["check", "--quiet", "--profile", PROFILE, "-p", name]))
}

/// Crates that the program must not link without its features.
const DRAWING: [&str; 6] = ["adumbra-compare", "adumbra-render", "adumbra-view", "egui", "wgpu", "winit"];

/// Checks that the program without its features links no crate that draws.
pub(crate) fn lean_program(root: &Path) -> Result<(), String> {
    let tree = [&["tree", "-e", "normal", "--prefix", "none"], &LEAN_PROGRAM[..]].concat();
    let tree = Cargo::new(root).output(&tree)?;
    let linked: BTreeSet<&str> = tree.lines().filter_map(|l| l.split(' ').next()).collect();
    if !linked.contains("adumbra") {
        return Err("cargo tree does not list what adumbra-cli links".to_owned());
    }
    match DRAWING.iter().find(|name| linked.contains(*name)) {
        Some(name) => Err(format!("adumbra-cli links {name} without its features")),
        None => Ok(()),
    }
}
