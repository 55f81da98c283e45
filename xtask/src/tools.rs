//! Tools that the tests need besides Rust: a Vulkan driver; for the window a headless X server, the libraries
//! that winit opens at run time, and `xdotool`; for the report's page a headless browser; for the package of
//! web pages Node.js, and an OpenGL for the browser; for the package for Python a Python that makes virtual
//! environments.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A tool that tests need, how it is found, and its packages' names.
struct Tool {
    what: &'static str,
    found: Found,
    debian: &'static str,
    fedora: &'static str,
}

/// How to find out whether a tool is installed.
enum Found {
    VulkanDriver,
    /// One of these commands is in the `PATH`.
    Command(&'static [&'static str]),
    /// A file of this name is in a folder that the loader searches.
    Library(&'static str),
    /// `python3` makes virtual environments.
    Venv,
}

const DRIVER: Tool = Tool {
    what: "a Vulkan driver",
    found: Found::VulkanDriver,
    debian: "mesa-vulkan-drivers",
    fedora: "mesa-vulkan-drivers",
};

/// For the tests that press keys in a window.
const KEYS: Tool = command("xdotool", &["xdotool"], "xdotool", "xdotool");

const BROWSER: Tool = command(
    "Chromium",
    &["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"],
    "chromium",
    "chromium",
);

/// For the package for web pages and the encoders of compressed scenes.
const NODE: Tool = command("Node.js with npm", &["npm"], "npm", "nodejs-npm");

/// For the package for Python.
const PYTHON: Tool =
    Tool { what: "Python 3 with venv", found: Found::Venv, debian: "python3-venv", fedora: "python3" };

const XVFB: Tool = command("Xvfb", &["Xvfb"], "xvfb", "xorg-x11-server-Xvfb");

/// For a browser that draws with OpenGL without a screen.
const OPENGL: [Tool; 3] = [
    XVFB,
    command("xauth", &["xauth"], "xauth", "xorg-x11-xauth"),
    library("libGLX_mesa.so.0", "libglx-mesa0", "mesa-libGL"),
];

/// Tools and libraries for opening a window without a screen.
const WINDOW: [Tool; 8] = [
    XVFB,
    library("libX11.so.6", "libx11-6", "libX11"),
    library("libX11-xcb.so.1", "libx11-xcb1", "libX11-xcb"),
    library("libXcursor.so.1", "libxcursor1", "libXcursor"),
    library("libXi.so.6", "libxi6", "libXi"),
    library("libXrandr.so.2", "libxrandr2", "libXrandr"),
    library("libxkbcommon.so.0", "libxkbcommon0", "libxkbcommon"),
    library("libxkbcommon-x11.so.0", "libxkbcommon-x11-0", "libxkbcommon-x11"),
];

const fn command(
    what: &'static str,
    names: &'static [&'static str],
    debian: &'static str,
    fedora: &'static str,
) -> Tool {
    Tool { what, found: Found::Command(names), debian, fedora }
}

const fn library(name: &'static str, debian: &'static str, fedora: &'static str) -> Tool {
    Tool { what: name, found: Found::Library(name), debian, fedora }
}

/// Makes sure that a Linux machine has a Vulkan driver: tries to install Mesa's with apt-get, or else names
/// the packages. Other systems come with an adapter.
pub(crate) fn ensure_driver() -> Result<(), String> {
    ensure(&[DRIVER])
}

/// Makes sure that everything the documents' commands need is installed, like [`ensure_driver`]: the driver,
/// and what opens a window.
pub(crate) fn ensure_documents() -> Result<(), String> {
    ensure(&documents())
}

/// Makes sure that everything the full tests need is installed, like [`ensure_driver`]: the driver, the
/// window's tools, the browser, and Node.js for the encoders of compressed scenes.
pub(crate) fn ensure_all() -> Result<(), String> {
    ensure(&all())
}

/// Makes sure that Node.js, a browser and an OpenGL are installed, like [`ensure_driver`].
pub(crate) fn ensure_web() -> Result<(), String> {
    ensure(&[NODE, BROWSER].into_iter().chain(OPENGL).collect::<Vec<_>>())
}

/// Makes sure that Python and its virtual environments are installed, like [`ensure_driver`].
pub(crate) fn ensure_python() -> Result<(), String> {
    ensure(&[PYTHON])
}

fn documents() -> Vec<Tool> {
    [DRIVER].into_iter().chain(WINDOW).collect()
}

fn all() -> Vec<Tool> {
    documents().into_iter().chain([KEYS, BROWSER, NODE]).collect()
}

fn ensure(tools: &[Tool]) -> Result<(), String> {
    if !cfg!(target_os = "linux") {
        return Ok(());
    }
    let missing: Vec<&Tool> = tools.iter().filter(|t| !t.found.holds()).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let packages: Vec<&str> = missing.iter().map(|t| t.debian).collect();
    eprintln!("missing: {}; trying: apt-get install {}", names(&missing), packages.join(" "));
    // Ignore a failed update: an old list of packages may still be enough.
    let _ = apt(&["update"]);
    apt(&[&["install", "--yes", "--no-install-recommends"], packages.as_slice()].concat());
    let missing: Vec<&Tool> = missing.into_iter().filter(|t| !t.found.holds()).collect();
    if missing.is_empty() { Ok(()) } else { Err(how_to_install(&missing)) }
}

fn how_to_install(missing: &[&Tool]) -> String {
    let list =
        |name: fn(&Tool) -> &'static str| missing.iter().map(|t| name(t)).collect::<Vec<_>>().join(" ");
    let software = if missing.iter().any(|t| matches!(t.found, Found::VulkanDriver)) {
        " (a software driver is enough)"
    } else {
        ""
    };
    format!(
        "the tests need {}{software}; Debian, Ubuntu: apt-get install {}; Fedora: dnf install {}",
        names(missing),
        list(|t| t.debian),
        list(|t| t.fedora)
    )
}

fn names(tools: &[&Tool]) -> String {
    tools.iter().map(|t| t.what).collect::<Vec<_>>().join(", ")
}

impl Found {
    fn holds(&self) -> bool {
        match self {
            Self::VulkanDriver => has_driver(),
            Self::Command(names) => {
                let path = env::var_os("PATH").unwrap_or_default();
                env::split_paths(&path).any(|folder| names.iter().any(|name| folder.join(name).is_file()))
            }
            Self::Venv => {
                let made = Command::new("python3").args(["-c", "import ensurepip, venv"]).output();
                made.is_ok_and(|o| o.status.success())
            }
            Self::Library(name) => library_folders().iter().any(|folder| folder.join(name).exists()),
        }
    }
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

/// Returns the folders that the loader searches: those that the user names, the usual ones, and below them
/// Debian's folder for each architecture.
fn library_folders() -> Vec<PathBuf> {
    let mut folders: Vec<PathBuf> =
        env::split_paths(&env::var_os("LD_LIBRARY_PATH").unwrap_or_default()).collect();
    for base in ["/usr/lib64", "/lib64", "/usr/local/lib", "/usr/lib", "/lib"] {
        folders.push(base.into());
        let below = Path::new(base).read_dir().into_iter().flatten().flatten().map(|f| f.path());
        folders.extend(below.filter(|f| f.to_string_lossy().contains("-linux-")));
    }
    folders
}

fn apt(arguments: &[&str]) -> bool {
    let status = Command::new("apt-get").args(arguments).env("DEBIAN_FRONTEND", "noninteractive").status();
    status.is_ok_and(|s| s.success())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_tools_are_named_for_debian_and_fedora() {
        let absent = [command("a thing", &["no-such-thing"], "deb-thing", "fed-thing"), DRIVER];
        assert!(!absent[0].found.holds());
        let message = how_to_install(&absent.iter().collect::<Vec<_>>());
        for part in [
            "a thing, a Vulkan driver (a software driver",
            "apt-get install deb-thing mesa",
            "dnf install fed-thing mesa",
        ] {
            assert!(message.contains(part), "{part:?} is not in {message}");
        }
    }

    #[test]
    fn tools_of_documents_open_windows_but_press_no_keys() {
        let [documents, all] = [documents(), all()].map(|t| names(&t.iter().collect::<Vec<_>>()));
        assert!(documents.starts_with("a Vulkan driver, Xvfb, libX11.so.6"), "{documents}");
        assert_eq!(all, format!("{documents}, xdotool, Chromium, Node.js with npm"));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn commands_are_found_in_path() {
        assert!(Found::Command(&["no-such-thing", "sh"]).holds());
        assert!(!Found::Library("libno-such-thing.so.1").holds());
    }
}
