//! The two executables that `adumbra-lab` runs: itself, and `adumbra` in the same folder, whose verbs the
//! benchmarks and the report measure.

use adumbra::IoError;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use adumbra_program::exit::Failure;

use adumbra_compare::Result;

/// Version and revision of this program.
pub const VERSION: &str = env!("ADUMBRA_VERSION");
/// Git revision of the sources of this program, with `-dirty` if they had uncommitted changes; empty if git
/// could not tell.
pub(crate) const REVISION: &str = env!("ADUMBRA_REVISION");

const HOW_TO_BUILD: &str = "build both with: cargo build --release -p adumbra-cli -p adumbra-lab";

/// The program that runs a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Program {
    /// `adumbra`.
    Product,
    /// `adumbra-lab`, this program.
    Laboratory,
}

impl Program {
    /// Returns the name as typed on a command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Product => "adumbra",
            Self::Laboratory => "adumbra-lab",
        }
    }

    /// Returns the path of the executable.
    ///
    /// # Errors
    /// Returns [`adumbra_compare::Error::Program`] if `adumbra` is missing or was built from other sources
    /// than this program.
    pub(crate) fn path(self) -> Result<PathBuf> {
        match self {
            Self::Laboratory => Ok(std::env::current_exe().map_err(IoError::at("find", "this program"))?),
            Self::Product => product(),
        }
    }
}

/// Returns the path of `adumbra`, in the folder of this program. Checks its version on the first call only.
fn product() -> Result<PathBuf> {
    static FOUND: OnceLock<PathBuf> = OnceLock::new();
    if let Some(path) = FOUND.get() {
        return Ok(path.clone());
    }
    let own = Program::Laboratory.path()?;
    let path = own.with_file_name(format!("adumbra{}", std::env::consts::EXE_SUFFIX));
    check_version(&path)?;
    Ok(FOUND.get_or_init(|| path).clone())
}

fn check_version(path: &Path) -> Result<()> {
    let missing = || {
        Failure::BadInput(format!(
            "{}: program not found, but adumbra-lab runs it; {HOW_TO_BUILD}",
            path.display()
        ))
    };
    if !path.is_file() {
        return Err(missing().into());
    }
    let output = Command::new(path).arg("--version").output().map_err(IoError::at("run", path))?;
    let said = String::from_utf8_lossy(&output.stdout);
    let version = said.trim().strip_prefix("adumbra ").unwrap_or_default();
    if committed(version) == committed(VERSION) {
        return check_features(path);
    }
    Err(Failure::BadInput(format!(
        "{}: its version is {version}, but adumbra-lab is {VERSION}; {HOW_TO_BUILD}",
        path.display()
    ))
    .into())
}

/// Checks that `adumbra` draws. The lean program has the same name and the same version.
fn check_features(path: &Path) -> Result<()> {
    let output = Command::new(path).args(["render", "--help"]).output().map_err(IoError::at("run", path))?;
    if output.status.success() {
        return Ok(());
    }
    let what = "was built without the feature render, whose verbs adumbra-lab runs";
    Err(Failure::BadInput(format!("{}: it {what}; {HOW_TO_BUILD}", path.display())).into())
}

/// Removes `-dirty` from a version: uncommitted changes may be in sources that only one of the programs has.
fn committed(version: &str) -> String {
    version.replace("-dirty", "")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn version_check_ignores_dirty_suffix() {
        assert_eq!(committed("0.1.0 (abc-dirty)"), committed("0.1.0 (abc)"));
        assert_ne!(committed("0.1.0 (abd)"), committed("0.1.0 (abc)"));
    }

    #[test]
    fn missing_program_error_names_build_command() {
        let error = check_version(Path::new("/nowhere/adumbra")).unwrap_err().to_string();
        assert!(error.starts_with("/nowhere/adumbra: ") && error.contains("-p adumbra-cli"), "{error}");
    }
}
