//! The tests of the code outside the workspace: the plugin for Bevy, and the packages for three.js and for
//! Python.

use std::env;
use std::path::{Path, PathBuf};

use crate::runner::{self, Tests};
use crate::steps::{Cargo, PROFILE, Steps, output, run, target_folder};
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

/// Tests the package for Python as a user would install it: as a wheel, in an environment with only the
/// packages that the tests need. The environment is used again as long as these and Python stay the same.
/// With `is_long`, runs the slow tests too.
pub(crate) fn python(root: &Path, is_long: bool) -> Result<(), String> {
    tools::ensure_python()?;
    let mut steps = Steps::default();
    let package = root.join("python");
    steps.run("python format", || Cargo::new(&package).run(&["fmt", "--all", "--check"]));
    let target = target_folder(root);
    let (environment, wheels) = (target.join("python"), target.join("wheels"));
    let python = environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let python = |arguments: &[&str], variables: &[(&str, &str)]| {
        run(&package, &python.to_string_lossy(), &[&["-m"], arguments].concat(), variables)
    };
    let pip = ["pip", "--disable-pip-version-check", "install", "--quiet", "--no-compile"];
    let is_ready = steps.run("python packages", || {
        let packages = std::fs::read_to_string(package.join(REQUIREMENTS));
        let packages = packages.map_err(|e| format!("{REQUIREMENTS}: {e}"))?;
        let wanted = output(root, "python3", &["--version"])? + &packages;
        let installed = environment.join(REQUIREMENTS);
        if std::fs::read_to_string(&installed).is_ok_and(|found| found == wanted) {
            return Ok(());
        }
        run(root, "python3", &["-m", "venv", "--clear", &environment.to_string_lossy()], &[])?;
        python(&[&pip[..], &["-r", REQUIREMENTS]].concat(), &[])?;
        std::fs::write(&installed, wanted).map_err(|e| format!("{}: {e}", installed.display()))
    });
    let is_installed = is_ready
        && steps.run("python wheel", || {
            if wheels.exists() {
                std::fs::remove_dir_all(&wheels)
                    .map_err(|e| format!("cannot remove {}: {e}", wheels.display()))?;
            }
            let wheels = wheels.to_string_lossy();
            python(
                &["maturin", "build", "--profile", PROFILE, "--locked", "--out", &wheels],
                &Cargo::linting(&package)?.variables(),
            )?;
            python(
                &[
                    &pip[..],
                    &["--no-index", "--no-deps", "--force-reinstall", "--find-links", &wheels, "adumbra"],
                ]
                .concat(),
                &[],
            )
        });
    if is_installed {
        steps.run("python tests", || {
            let program = built_program(root)?;
            let shared =
                env::var("ADUMBRA_SHARED").unwrap_or_else(|_| root.join("../shared").display().to_string());
            let variables = [("ADUMBRA_BIN", &*program.to_string_lossy()), ("ADUMBRA_SHARED", &shared)];
            let slow: &[&str] = if is_long { &[] } else { &["-m", "not slow"] };
            python(&[&["pytest", "--durations", "10"], slow].concat(), &variables)
        });
    }
    steps.finish()
}

/// The packages that the tests of the package for Python need.
const REQUIREMENTS: &str = "requirements-test.txt";

/// Builds the programs as the tests do, so that nothing is built twice. Returns the path of the product.
fn built_program(root: &Path) -> Result<PathBuf, String> {
    Cargo::linting(root)?.run(&docs::BUILD)?;
    Ok(target_folder(root).join(PROFILE).join("adumbra"))
}
