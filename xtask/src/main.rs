//! Development tasks: `cargo xtask test [--quick]`, `cargo xtask test-bevy`, `cargo xtask test-web`,
//! `cargo xtask test-python`, `cargo xtask docs [--quick]`, `cargo xtask vectors`, `cargo xtask shaders-web`, `cargo xtask api`,
//! `cargo xtask count [--bless]`.

mod api;
#[cfg(test)]
mod arrows;
mod docs;
mod tools;

use std::collections::BTreeSet;
use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;

const USAGE: &str = "usage:
  cargo xtask test            formatting, lints, documentation, every test, the documents' commands
  cargo xtask test --quick    only the tests that are not marked slow; under two minutes
  cargo xtask test-bevy       formatting, lints and tests of integrations/bevy_adumbra, which builds Bevy; documentation with ADUMBRA_FULL
  cargo xtask test-web        types, lints, builds and tests of integrations/three, in Node.js and in a browser
  cargo xtask test-python     formatting, lints, types and tests of the package in python, and its notebook, in a fresh environment
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
        ["test-python"] => test_python(root),
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
    if !builds_lint() {
        cargo(root, &["clippy", "--release", "--workspace", "--all-targets", "--", "-D", "warnings"], &[])?;
        cargo(root, &["doc", "--release", "--workspace", "--no-deps"], &[("RUSTDOCFLAGS", "-D warnings")])?;
    }
    check_baker(root)?;
    tools::ensure_all()?;
    run(&root.join(ENCODERS), "npm", &["ci", "--no-audit", "--no-fund"], &[])?;
    let tests = ["test", "--release", "--workspace", "--no-fail-fast", "--", "--include-ignored"];
    cargo(root, &tests, &[("ADUMBRA_REQUIRE_TOOLS", "1")])?;
    docs::run(root, &["--quick"]).map_err(|e| e.to_string())
}

/// Tests the plugin for Bevy, which is no member of the workspace: Bevy has a wgpu of its own. Its documentation is built with
/// `ADUMBRA_FULL` alone: that checks all of Bevy once more.
fn test_bevy(root: &Path) -> Result<(), String> {
    tools::ensure_driver()?;
    let plugin = root.join("integrations/bevy_adumbra");
    cargo(&plugin, &["fmt", "--all", "--check"], &[])?;
    if env::var_os("ADUMBRA_FULL").is_some() {
        cargo(&plugin, &["doc", "--no-deps", "--all-features"], &[("RUSTDOCFLAGS", "-D warnings")])?;
    }
    let driver = clippy_driver()?;
    let lints = [("RUSTC_WORKSPACE_WRAPPER", driver.as_str()), ("CLIPPY_ARGS", DENY_WARNINGS)];
    cargo(&plugin, &["test", "--all-features"], &lints)
}

/// Whether cargo builds with clippy's compiler, as `.ci/run` has it do. Then nothing is compiled once more to be linted or
/// documented, which would check every dependency first.
fn builds_lint() -> bool {
    env::var("RUSTC_WORKSPACE_WRAPPER").is_ok_and(|compiler| compiler.contains("clippy-driver"))
}

/// The arguments `-D warnings` as `cargo clippy` hands them to clippy's compiler.
const DENY_WARNINGS: &str = "-D__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__";

/// Returns the path of clippy's compiler, which lints what it builds. `cargo clippy` has it check without building, and cargo
/// then compiles every dependency once to check and once to build.
fn clippy_driver() -> Result<String, String> {
    let sysroot = Command::new("rustc").args(["--print", "sysroot"]).output();
    let sysroot = sysroot.map_err(|e| format!("cannot run rustc: {e}"))?.stdout;
    let name = if cfg!(windows) { "clippy-driver.exe" } else { "clippy-driver" };
    let driver = Path::new(String::from_utf8_lossy(&sysroot).trim()).join("bin").join(name);
    if driver.exists() {
        return Ok(driver.display().to_string());
    }
    Err("clippy is missing; install it with: rustup component add clippy".to_owned())
}

/// Tests the package for three.js: its unit tests compare look-ups with the program's, its browser tests draw, and its
/// guide is walked.
fn test_web(root: &Path) -> Result<(), String> {
    tools::ensure_web()?;
    let program = built_program(root)?;
    let generator = root.join(GENERATOR);
    cargo(&generator, &["fmt", "--all", "--check"], &[])?;
    if !builds_lint() {
        cargo(&generator, &["clippy", "--all-targets", "--", "-D", "warnings"], &[])?;
    }
    cargo(&generator, &["test"], &[])?;
    let package = root.join("integrations/three");
    run(&package, "npm", &["ci", "--no-audit", "--no-fund"], &[])?;
    run(&package, "npm", &["run", "check"], &[("ADUMBRA_BIN", &program.to_string_lossy())])?;
    docs::run(root, &[WEB_GUIDE]).map_err(|e| e.to_string())
}

/// Tests the package for Python as a user would install it: a wheel, in an environment that holds nothing else than what the
/// tests need.
fn test_python(root: &Path) -> Result<(), String> {
    tools::ensure_python()?;
    let program = built_program(root)?;
    let package = root.join("python");
    cargo(&package, &["fmt", "--all", "--check"], &[])?;
    if !builds_lint() {
        cargo(&package, &["clippy", "--release", "--all-targets", "--locked", "--", "-D", "warnings"], &[])?;
    }
    let (environment, wheels) = (root.join("target/python"), root.join("target/wheels"));
    run(root, "python3", &["-m", "venv", "--clear", &environment.to_string_lossy()], &[])?;
    let python = environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let python = |arguments: &[&str], variables: &[(&str, &str)]| {
        run(&package, &python.to_string_lossy(), &[&["-m"], arguments].concat(), variables)
    };
    let pip = ["pip", "--disable-pip-version-check", "install", "--quiet", "--no-compile"];
    python(&[&pip[..], &["-r", "requirements-test.txt"]].concat(), &[])?;
    if wheels.exists() {
        std::fs::remove_dir_all(&wheels).map_err(|e| format!("cannot remove {}: {e}", wheels.display()))?;
    }
    let wheels = wheels.to_string_lossy();
    python(&["maturin", "build", "--release", "--locked", "--out", &wheels], &[])?;
    python(&[&pip[..], &["--no-index", "--no-deps", "--find-links", &wheels, "adumbra"]].concat(), &[])?;
    let shared = env::var("ADUMBRA_SHARED").unwrap_or_else(|_| root.join("../shared").display().to_string());
    python(&["pytest"], &[("ADUMBRA_BIN", &program.to_string_lossy()), ("ADUMBRA_SHARED", &shared)])
}

/// Builds the programs as the tests and the documents do, so that nothing is built twice. Returns the path of the product.
fn built_program(root: &Path) -> Result<PathBuf, String> {
    cargo(root, &docs::BUILD, &[])?;
    Ok(root.join("target/release/adumbra"))
}

/// Checks that the program without its features builds and links nothing that draws.
fn check_baker(root: &Path) -> Result<(), String> {
    let baker = ["-p", "adumbra-cli", "--no-default-features"];
    if !builds_lint() {
        cargo(root, &[&["clippy", "--release"], &baker[..], &["--", "-D", "warnings"]].concat(), &[])?;
    }
    if env::var_os("ADUMBRA_FULL").is_some() {
        // Tests of the whole workspace have every feature of the scene loaders. These two read small files: what they link is
        // built twice as fast without optimisation.
        let plain = [("CARGO_PROFILE_DEV_DEBUG", "0"), ("CARGO_INCREMENTAL", "0")];
        cargo(root, &["test", "-p", "adumbra-scene", "--test", "draco"], &plain)?;
    }
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

/// Leaves out what `cargo run` says of this package: build scripts that ask for it would run again after each change between
/// `cargo xtask` and `cargo`.
fn outside_cargo(command: &mut Command) -> &mut Command {
    let is_of_package = |name: &str| name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_");
    for (name, _) in env::vars().filter(|(name, _)| is_of_package(name)) {
        command.env_remove(name);
    }
    command
}

fn run(folder: &Path, program: &str, args: &[&str], environment: &[(&str, &str)]) -> Result<(), String> {
    let line = format!("{program} {}", args.join(" "));
    eprintln!("{line}");
    let start = Instant::now();
    let status = outside_cargo(&mut Command::new(program))
        .args(args)
        .envs(environment.iter().copied())
        .current_dir(folder)
        .status()
        .map_err(|e| format!("cannot run {program}: {e}"))?;
    eprintln!("{} s: {line}", start.elapsed().as_secs());
    if status.success() { Ok(()) } else { Err(format!("{line} failed")) }
}
