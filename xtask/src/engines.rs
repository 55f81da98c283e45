//! The tests of the plugin for Bevy and of the package for three.js.

use std::path::{Path, PathBuf};

use crate::runner::{self, Tests};
use crate::steps::{Cargo, PROFILE, Steps, run, target_folder};
use crate::{docs, tools};

/// The guide whose commands make a page from an empty folder.
const WEB_GUIDE: &str = "docs/guides/use-it-on-a-web-page.md";
/// The program that generates the look-ups of web pages.
pub(crate) const GENERATOR: &str = "integrations/three/generator";

/// Lints and tests the plugin for Bevy. The plugin is not a member of the workspace, because Bevy has its own
/// version of wgpu. With `is_long`, also builds the documentation and the examples.
pub(crate) fn bevy(root: &Path, is_long: bool) -> Result<(), String> {
    let plugin = root.join("integrations/bevy_adumbra");
    let mut steps = Steps::default();
    steps.run("bevy tools", tools::ensure_driver);
    steps.run("bevy format", || Cargo::new(&plugin).run(&["fmt", "--all", "--check"]));
    if is_long {
        steps.run("bevy documentation", || {
            let doc = ["doc", "--no-deps", "--all-features"];
            Cargo::new(&plugin).with("RUSTDOCFLAGS", "-D warnings").run(&doc)
        });
    }
    let targets: &[&str] =
        if is_long { &["--all-features"] } else { &["--all-features", "--lib", "--tests"] };
    let build = ["test", "--quiet", "--no-run"];
    if steps.run("bevy build", || Cargo::linting(&plugin)?.run(&[&build[..], targets].concat())) {
        steps.run("bevy tests", || {
            runner::run(
                &Cargo::linting(&plugin)?,
                "dev",
                targets,
                &if is_long { Tests::All } else { Tests::NotSlow },
            )
        });
    }
    steps.finish()
}

/// Tests the package for three.js: its unit tests compare look-ups with the program's, and its browser tests
/// draw. With `is_long`, runs all browser tests and the guide.
pub(crate) fn web(root: &Path, is_long: bool) -> Result<(), String> {
    let mut steps = Steps::default();
    steps.run("web tools", tools::ensure_web);
    let generator = root.join(GENERATOR);
    steps.run("web generator", || {
        Cargo::new(&generator).run(&["fmt", "--all", "--check"])?;
        Cargo::linting(&generator)?.run(&["test", "--quiet"])
    });
    let package = root.join("integrations/three");
    let program = match built_program(root) {
        Ok(program) => program.display().to_string(),
        Err(fault) => return Err(fault),
    };
    let npm = |arguments: &[&str]| run(&package, "npm", arguments, &[("ADUMBRA_BIN", &program)]);
    if !steps.run("web packages", || npm(&["ci", "--no-audit", "--no-fund"])) {
        return steps.finish();
    }
    let scripts: &[&str] = if is_long {
        &["types", "build", "test:package", "test", "test:browser", "test:truth"]
    } else {
        &["types", "build", "test:package", "test", "test:browser:short"]
    };
    for script in scripts {
        steps.run(&format!("web {script}"), || npm(&["run", script]));
    }
    if is_long {
        steps.run("web guide", || docs::run(root, &[WEB_GUIDE]).map_err(|e| e.to_string()));
    }
    steps.finish()
}

/// Builds the programs as the tests do, so that nothing is built twice. Returns the path of the product.
pub(crate) fn built_program(root: &Path) -> Result<PathBuf, String> {
    Cargo::linting(root)?.run(&docs::BUILD)?;
    Ok(target_folder(root).join(PROFILE).join("adumbra"))
}
