//! A GPU adapter for the tests: any Vulkan driver, or Mesa's software Vulkan.

use std::env;
use std::path::Path;
use std::process::Command;

const PACKAGE: &str = "mesa-vulkan-drivers";

/// Makes sure that a machine with Linux has a Vulkan driver: installs Mesa's where that is one command, or names it. Other
/// systems bring an adapter of their own.
pub(crate) fn ensure() -> Result<(), String> {
    if !cfg!(target_os = "linux") || has_driver() {
        return Ok(());
    }
    let missing = format!(
        "the GPU tests need a Vulkan driver; a software one is enough (Debian, Ubuntu: apt-get install {PACKAGE}; Fedora: dnf install \
         {PACKAGE})"
    );
    eprintln!("no Vulkan driver is installed; trying: apt-get install {PACKAGE}");
    // An old list of packages may still do.
    let _ = apt(&["update"]);
    if apt(&["install", "--yes", "--no-install-recommends", PACKAGE]) && has_driver() {
        return Ok(());
    }
    Err(missing)
}

fn has_driver() -> bool {
    let named = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].iter().any(|v| env::var_os(v).is_some());
    let folders = ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
    let holds_a_driver = |folder: &&str| {
        let files = Path::new(folder).read_dir().into_iter().flatten().flatten();
        files.into_iter().any(|f| f.path().extension().is_some_and(|e| e == "json"))
    };
    named || folders.iter().any(holds_a_driver)
}

fn apt(arguments: &[&str]) -> bool {
    let status = Command::new("apt-get").args(arguments).env("DEBIAN_FRONTEND", "noninteractive").status();
    status.is_ok_and(|s| s.success())
}
