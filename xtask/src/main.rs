//! Development tasks: `cargo xtask test [--quick]`, `cargo xtask test-bevy`, `cargo xtask test-web`,
//! `cargo xtask docs [--quick]`, `cargo xtask vectors`, `cargo xtask shaders-web`, `cargo xtask api`,
//! `cargo xtask count [--bless]`.

mod api;
#[cfg(test)]
mod arrows;
mod docs;
mod tools;

use std::collections::BTreeSet;
use std::env;
use std::path::Path;
use std::process::{Command, ExitCode};

const USAGE: &str = "usage:
  cargo xtask test            formatting, lints, documentation, every test, the documents' commands
  cargo xtask test --quick    only the tests that are not marked slow; under two minutes
  cargo xtask test-bevy       formatting, lints, documentation and tests of integrations/bevy_adumbra, which builds Bevy
  cargo xtask test-web        types, lints, builds and tests of integrations/three, in Node.js and in a browser
  cargo xtask docs            run every command of README and docs/ in a copy of the repository, check its output; check links
  cargo xtask docs --quick    use existing builds and smaller numbers, only parse the arguments of long commands; FILE... reads only these files
  cargo xtask vectors         regenerate test_vectors/
  cargo xtask shaders-web     regenerate the look-ups of integrations/three from the workspace's WGSL
  cargo xtask api             regenerate docs/api.txt, the public items of the reader
  cargo xtask count           compare instruction counts of the hot steps with docs/counts.json; --bless writes it";

/// Its commands make a page from an empty folder; the tests of the package run them.
const WEB_GUIDE: &str = "docs/guides/use-it-on-a-web-page.md";
/// The encoders that tests of compressed scenes run.
const ENCODERS: &str = "xtask/encoders";
/// Makes the look-ups of web pages.
const GENERATOR: &str = "integrations/three/generator";

/// Runs the tasks that bake.
const BAKES: [&str; 6] = ["run", "--quiet", "--release", "--package", "xtask-bakes", "--"];

fn main() -> ExitCode {
    let args: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."));
    let outcome = match words.as_slice() {
        ["test"] => test(root),
        ["test", "--quick"] => quick_test(root),
        ["test-bevy"] => test_bevy(root),
        ["test-web"] => test_web(root),
        ["shaders-web"] => cargo(&root.join(GENERATOR), &["run", "--quiet"], &[]),
        ["docs", options @ ..] => {
            tools::ensure_documents().and_then(|()| docs::run(root, options).map_err(|e| e.to_string()))
        }
        ["api"] => write_api(root),
        ["vectors" | "count", ..] => cargo(root, &[&BAKES, words.as_slice()].concat(), &[]),
        _ => Err(USAGE.to_owned()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn write_api(root: &Path) -> Result<(), String> {
    let (text, items) = api::list(root)?;
    std::fs::write(root.join(api::LIST), text).map_err(|e| format!("cannot write {}: {e}", api::LIST))?;
    println!("{items} items");
    Ok(())
}

fn test(root: &Path) -> Result<(), String> {
    for component in ["rustfmt", "clippy"] {
        let found = Command::new("cargo").args([component_verb(component), "--version"]).output();
        if !found.is_ok_and(|o| o.status.success()) {
            return Err(format!("{component} is missing; install it with: rustup component add {component}"));
        }
    }
    cargo(root, &["fmt", "--all", "--check"], &[])?;
    cargo(root, &["clippy", "--release", "--workspace", "--all-targets", "--", "-D", "warnings"], &[])?;
    check_baker(root)?;
    cargo(root, &["doc", "--release", "--workspace", "--no-deps"], &[("RUSTDOCFLAGS", "-D warnings")])?;
    tools::ensure_all()?;
    run(&root.join(ENCODERS), "npm", &["ci", "--no-audit", "--no-fund"], &[])?;
    let tests = ["test", "--release", "--workspace", "--no-fail-fast", "--", "--include-ignored"];
    cargo(root, &tests, &[("ADUMBRA_REQUIRE_TOOLS", "1")])?;
    docs::run(root, &["--quick"]).map_err(|e| e.to_string())
}

/// Tests the plugin for Bevy, which is no member of the workspace: Bevy has a wgpu of its own.
fn test_bevy(root: &Path) -> Result<(), String> {
    tools::ensure_driver()?;
    let plugin = root.join("integrations/bevy_adumbra");
    cargo(&plugin, &["fmt", "--all", "--check"], &[])?;
    cargo(&plugin, &["clippy", "--all-targets", "--all-features", "--", "-D", "warnings"], &[])?;
    cargo(&plugin, &["doc", "--no-deps", "--all-features"], &[("RUSTDOCFLAGS", "-D warnings")])?;
    cargo(&plugin, &["test", "--all-features"], &[])
}

/// Tests the package for three.js: its unit tests compare look-ups with the program's, its browser tests draw, and its
/// guide is walked.
fn test_web(root: &Path) -> Result<(), String> {
    tools::ensure_web()?;
    cargo(root, &["build", "--release", "--package", "adumbra-cli"], &[])?;
    let program = root.join("target/release/adumbra");
    let generator = root.join(GENERATOR);
    cargo(&generator, &["fmt", "--all", "--check"], &[])?;
    cargo(&generator, &["clippy", "--all-targets", "--", "-D", "warnings"], &[])?;
    cargo(&generator, &["test"], &[])?;
    let package = root.join("integrations/three");
    run(&package, "npm", &["ci", "--no-audit", "--no-fund"], &[])?;
    run(&package, "npm", &["run", "check"], &[("ADUMBRA_BIN", &program.to_string_lossy())])?;
    docs::run(root, &[WEB_GUIDE]).map_err(|e| e.to_string())
}

/// Checks that the program without its features builds and links nothing that draws.
fn check_baker(root: &Path) -> Result<(), String> {
    let baker = ["-p", "adumbra-cli", "--no-default-features"];
    cargo(root, &[&["clippy", "--release"], &baker[..], &["--", "-D", "warnings"]].concat(), &[])?;
    // Tests of the whole workspace have every feature of the scene loaders.
    cargo(root, &["test", "--release", "-p", "adumbra-scene", "--test", "draco"], &[])?;
    let tree = Command::new("cargo")
        .args([&["tree", "-e", "normal", "--prefix", "none"], &baker[..]].concat())
        .current_dir(root)
        .output()
        .map_err(|e| format!("cannot run cargo: {e}"))?;
    let tree = String::from_utf8_lossy(&tree.stdout);
    let linked: BTreeSet<&str> = tree.lines().filter_map(|l| l.split(' ').next()).collect();
    if !linked.contains("adumbra") {
        return Err("cargo tree does not list what adumbra-cli links".to_owned());
    }
    match DRAWING.iter().find(|name| linked.contains(*name)) {
        Some(name) => Err(format!("adumbra-cli links {name} without its features")),
        None => Ok(()),
    }
}

/// Crates that the program must not link without its features.
const DRAWING: [&str; 6] = ["adumbra-compare", "adumbra-render", "adumbra-view", "egui", "wgpu", "winit"];

fn quick_test(root: &Path) -> Result<(), String> {
    tools::ensure_driver()?;
    cargo(root, &["test", "--release", "--workspace"], &[])
}

fn component_verb(component: &str) -> &str {
    if component == "rustfmt" { "fmt" } else { component }
}

fn cargo(root: &Path, args: &[&str], environment: &[(&str, &str)]) -> Result<(), String> {
    run(root, "cargo", args, environment)
}

fn run(folder: &Path, program: &str, args: &[&str], environment: &[(&str, &str)]) -> Result<(), String> {
    eprintln!("{program} {}", args.join(" "));
    let status = Command::new(program)
        .args(args)
        .envs(environment.iter().copied())
        .current_dir(folder)
        .status()
        .map_err(|e| format!("cannot run {program}: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("{program} {} failed", args.join(" "))) }
}
