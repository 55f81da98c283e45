//! Checks that run no tests.

use std::collections::BTreeSet;
use std::path::Path;

use crate::steps::{self, Cargo, PROFILE, Steps};

/// Checks formatting, lints, documentation, the crates that the lean program links, each crate with each of
/// its features, the reader for the web, the fuzz targets, and the dependencies of all packages.
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
    steps.run("features", || features(root));
    steps.run("web", || web(root));
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
    require(root, "deny")?;
    LOCKED.iter().try_for_each(|folder| Cargo::new(&root.join(folder)).run(&check))
}

/// The program without its features.
const LEAN_PROGRAM: [&str; 3] = ["-p", "adumbra-cli", "--no-default-features"];

/// Checks each crate alone without features, with its default ones, with each one, and with all. In a build
/// of the whole workspace, cargo also enables the features that other crates request.
fn features(root: &Path) -> Result<(), String> {
    each_feature(root, &["--workspace"])
}

const WEBASSEMBLY: &str = "wasm32-unknown-unknown";

/// Checks what an app on a web page links, the reader and its shaders, for WebAssembly.
fn web(root: &Path) -> Result<(), String> {
    let installed = steps::output(root, "rustup", &["target", "list", "--installed"])?;
    if !installed.lines().any(|target| target == WEBASSEMBLY) {
        return Err(format!("{WEBASSEMBLY} is missing; install it with: rustup target add {WEBASSEMBLY}"));
    }
    each_feature(root, &["-p", "adumbra", "-p", "adumbra-shaders", "--target", WEBASSEMBLY])
}

fn each_feature(root: &Path, of: &[&str]) -> Result<(), String> {
    require(root, "hack")?;
    Cargo::new(root)
        .with("RUSTFLAGS", "-D warnings")
        .run(&[&["hack", "check", "--quiet", "--profile", PROFILE, "--each-feature"], of].concat())
}

/// Returns an error if cargo lacks a command that is installed separately.
fn require(root: &Path, command: &str) -> Result<(), String> {
    match steps::output(root, "cargo", &[command, "--version"]) {
        Ok(_) => Ok(()),
        Err(_) => Err(format!(
            "cargo-{command} is missing; install it with: cargo install --locked cargo-{command}"
        )),
    }
}

/// Crates that the program must not link without its features: those that draw, and remote stores.
const NOT_LEAN: [&str; 7] =
    ["adumbra-compare", "adumbra-render", "adumbra-view", "egui", "object_store", "wgpu", "winit"];

/// Checks what the program links without its features.
pub(crate) fn lean_program(root: &Path) -> Result<(), String> {
    let tree = [&["tree", "-e", "normal", "--prefix", "none"], &LEAN_PROGRAM[..]].concat();
    let tree = Cargo::new(root).output(&tree)?;
    let linked: BTreeSet<&str> = tree.lines().filter_map(|l| l.split(' ').next()).collect();
    if !linked.contains("adumbra") {
        return Err("cargo tree does not list what adumbra-cli links".to_owned());
    }
    match NOT_LEAN.iter().find(|name| linked.contains(*name)) {
        Some(name) => Err(format!("adumbra-cli links {name} without its features")),
        None => Ok(()),
    }
}
