//! Environment variables that the process needs, set before anything else runs.

/// On Linux, re-executes the program with `XDG_RUNTIME_DIR` set if the variable is not an absolute path.
/// Mesa's Vulkan layer for device selection asks Wayland for the compositor's device whatever is drawn, and
/// without the variable libwayland-client writes two errors to stderr. The folder that is set does not exist,
/// so that no compositor is found in it, just as none is found without the variable. Setting a variable
/// within a process is unsafe; starting a process with it is not.
#[cfg(target_os = "linux")]
pub(crate) fn set_runtime_folder() {
    use std::os::unix::process::CommandExt;

    const VARIABLE: &str = "XDG_RUNTIME_DIR";
    /// Debian's name for a folder that never exists.
    const NOWHERE: &str = "/nonexistent";
    let has_one =
        std::env::var_os(VARIABLE).is_some_and(|folder| std::path::Path::new(&folder).is_absolute());
    let mut words = std::env::args_os();
    if has_one {
        return;
    }
    let (Ok(program), Some(name)) = (std::env::current_exe(), words.next()) else { return };
    // `exec` returns only if it fails. Then the two errors are printed, and nothing else is wrong.
    let _ = std::process::Command::new(program).arg0(name).args(words).env(VARIABLE, NOWHERE).exec();
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn set_runtime_folder() {}
