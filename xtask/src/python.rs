//! The tests of the package for Python as a user would install it: as a wheel, in a virtual environment.

use std::env;
use std::fs::{read_dir, read_to_string, remove_dir_all, write};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::engines::built_program;
use crate::steps::{Cargo, PROFILE, Steps, output, run, target_folder};
use crate::tools;

/// The packages that the tests need, and those that only slow tests need.
const REQUIREMENTS: &str = "requirements-test.txt";
const MORE_REQUIREMENTS: &str = "requirements-long.txt";

/// The versions of Python that the wheel is for, with the packages that its tests cannot do without: the
/// oldest with the oldest NumPy that the package allows.
const VERSIONS: [(&str, &[&str]); 5] = [
    ("3.10", &["numpy==1.24.0", "pytest==9.2.0"]),
    ("3.11", &["numpy==1.26.0", "pytest==9.2.0"]),
    ("3.12", &["numpy==2.0.0", "pytest==9.2.0"]),
    ("3.13", &["numpy==2.4.6", "pytest==9.2.0"]),
    ("3.14", &["numpy==2.4.6", "pytest==9.2.0"]),
];

/// The other platforms that wheels are built for, with the part of the wheel's name that says so.
const PLATFORMS: [(&str, &str); 3] = [
    ("x86_64-unknown-linux-musl", "musllinux_1_2_x86_64"),
    ("aarch64-unknown-linux-gnu", "manylinux_2_17_aarch64"),
    ("aarch64-unknown-linux-musl", "musllinux_1_2_aarch64"),
];
/// The linker and C compiler for these.
const ZIG: &str = "ziglang==0.17.1";

/// Tests the package in an environment with only the packages that the tests need. The environment is used
/// again as long as these and Python stay the same. With `is_long`, runs the slow tests, the others with each
/// version of Python that is installed, and builds the wheels for other platforms.
pub(crate) fn test(root: &Path, is_long: bool) -> Result<(), String> {
    tools::ensure_python()?;
    let mut steps = Steps::default();
    let package = root.join("python");
    steps.run("python format", || Cargo::new(&package).run(&["fmt", "--all", "--check"]));
    let target = target_folder(root);
    let wheels = target.join("wheels");
    let environment = Environment { folder: target.join("python"), package: &package };
    let requirements =
        || read_to_string(package.join(REQUIREMENTS)).map_err(|e| format!("{REQUIREMENTS}: {e}"));
    let is_ready =
        steps.run("python packages", || environment.make("python3", &["-r", REQUIREMENTS], &requirements()?));
    let is_installed = is_ready
        && steps.run("python wheel", || {
            clear(&wheels)?;
            let variables = Cargo::linting(&package)?;
            environment.build(&wheels, &[], &variables.variables())?;
            environment.install(&wheels)
        });
    if is_installed {
        steps.run("python types", || environment.check_types());
        let slow: &[&str] = if is_long { &[] } else { NOT_SLOW };
        steps.run("python tests", || {
            if is_long {
                environment.pip(&["-r", MORE_REQUIREMENTS])?;
            }
            environment.test(root, slow)
        });
    }
    if is_installed && is_long {
        for (version, packages) in VERSIONS {
            let Some(python) = python_of(version) else {
                eprintln!("Python {version} is not installed, so the wheel is not tested with it");
                continue;
            };
            let environment =
                Environment { folder: target.join(format!("python{version}")), package: &package };
            steps.run(&format!("python {version}"), || {
                environment.make(&python, packages, &packages.join("\n"))?;
                environment.install(&wheels)?;
                environment.test(root, &[NOT_SLOW, IN_BARE_ENVIRONMENTS].concat())
            });
        }
        steps.run("python linker", || environment.pip(&[ZIG]));
        for (platform, tag) in PLATFORMS {
            steps.run(&format!("python wheel {platform}"), || {
                run(root, "rustup", &["target", "add", platform], &[])?;
                let folder = target.join("wheels-of-platforms").join(platform);
                clear(&folder)?;
                let python = environment.python();
                let linker = ("CARGO_ZIGBUILD_PYTHON_PATH", &*python.to_string_lossy());
                environment.build(&folder, &["--target", platform, "--zig"], &[linker])?;
                let names: Vec<String> = names_in(&folder)?;
                match &*names {
                    [name] if name.contains("-abi3-") && name.contains(tag) => Ok(()),
                    _ => Err(format!("{names:?} is not one wheel for {tag}")),
                }
            });
        }
    }
    steps.finish()
}

/// Options of pytest that leave out slow tests.
const NOT_SLOW: &[&str] = &["-m", "not slow"];
/// Options of pytest that leave out tests of documents and of types, which need more packages.
const IN_BARE_ENVIRONMENTS: &[&str] = &["--ignore=tests/test_documents.py", "--ignore=tests/test_types.py"];

/// A virtual environment for the package in the folder `package`.
struct Environment<'p> {
    folder: PathBuf,
    package: &'p Path,
}

impl Environment<'_> {
    /// Makes the environment with packages, unless it was made by the same Python for the same `wanted`.
    fn make(&self, python: &str, packages: &[&str], wanted: &str) -> Result<(), String> {
        let wanted = output(self.package, python, &["--version"])? + wanted;
        let installed = self.folder.join("packages.txt");
        if read_to_string(&installed).is_ok_and(|found| found == wanted) {
            return Ok(());
        }
        run(self.package, python, &["-m", "venv", "--clear", &self.folder.to_string_lossy()], &[])?;
        self.pip(packages)?;
        write(&installed, wanted).map_err(|e| format!("{}: {e}", installed.display()))
    }

    /// Installs packages.
    fn pip(&self, packages: &[&str]) -> Result<(), String> {
        let pip = ["pip", "--disable-pip-version-check", "install", "--quiet", "--no-compile"];
        self.run(&[&pip[..], packages].concat(), &[])
    }

    /// Builds a wheel in `wheels`.
    fn build(&self, wheels: &Path, options: &[&str], variables: &[(&str, &str)]) -> Result<(), String> {
        let wheels = wheels.to_string_lossy();
        let build = ["maturin", "build", "--profile", PROFILE, "--locked", "--out", &wheels];
        self.run(&[&build[..], options].concat(), variables)
    }

    /// Installs the package's wheel from `wheels`.
    fn install(&self, wheels: &Path) -> Result<(), String> {
        let wheels = wheels.to_string_lossy();
        self.pip(&["--no-index", "--no-deps", "--force-reinstall", "--find-links", &wheels, "adumbra"])
    }

    /// Checks the types of the package, its tests and its benchmarks.
    fn check_types(&self) -> Result<(), String> {
        // Beside the packages that are checked, so that a later run checks only what has changed.
        let cache = self.folder.join("mypy");
        let strict = ["mypy", "--strict", "--cache-dir", &cache.to_string_lossy()];
        self.run(&[&strict[..], &["--package", "adumbra", "--package", "adumbra_farm"]].concat(), &[])?;
        self.run(&[&strict[..], &["tests", "benches"]].concat(), &[])
    }

    /// Runs the tests that `options` select.
    fn test(&self, root: &Path, options: &[&str]) -> Result<(), String> {
        let program = built_program(root)?;
        let shared =
            env::var("ADUMBRA_SHARED").unwrap_or_else(|_| root.join("../shared").display().to_string());
        let variables = [("ADUMBRA_BIN", &*program.to_string_lossy()), ("ADUMBRA_SHARED", &shared)];
        self.run(&[&["pytest", "--durations", "10"], options].concat(), &variables)
    }

    /// Runs a module.
    fn run(&self, arguments: &[&str], variables: &[(&str, &str)]) -> Result<(), String> {
        run(self.package, &self.python().to_string_lossy(), &[&["-m"], arguments].concat(), variables)
    }

    fn python(&self) -> PathBuf {
        self.folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" })
    }
}

/// Returns the program of a version of Python: in the `PATH`, or installed by pyenv.
fn python_of(version: &str) -> Option<String> {
    let name = format!("python{version}");
    let mut found = vec![PathBuf::from(&name)];
    if let Some(home) = env::home_dir() {
        let installed = read_dir(home.join(".pyenv/versions")).into_iter().flatten().flatten();
        found.extend(installed.map(|folder| folder.path().join("bin").join(&name)));
    }
    let runs =
        |python: &PathBuf| Command::new(python).arg("--version").output().is_ok_and(|o| o.status.success());
    found.into_iter().find(runs).map(|python| python.to_string_lossy().into_owned())
}

/// Removes a folder if it exists.
fn clear(folder: &Path) -> Result<(), String> {
    if !folder.exists() {
        return Ok(());
    }
    remove_dir_all(folder).map_err(|e| format!("cannot remove {}: {e}", folder.display()))
}

/// Returns the names of a folder's files.
fn names_in(folder: &Path) -> Result<Vec<String>, String> {
    let files = read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    Ok(files.flatten().map(|file| file.file_name().to_string_lossy().into_owned()).collect())
}
