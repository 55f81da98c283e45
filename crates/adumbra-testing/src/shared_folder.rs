//! The folder of scenes and truth that are not part of the repository: `ADUMBRA_SHARED`, or `shared` next to the
//! checkout. `ADUMBRA_FULL=1` makes the tests use them at full size.

use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Returns a folder in the shared folder. If it is absent, the test should pass: it is left out, see [`left_out`].
///
/// # Panics
/// Panics if the folder is absent and `ADUMBRA_REQUIRE_SHARED` is set.
pub fn shared(folder: &str) -> Option<PathBuf> {
    let base = std::env::var_os("ADUMBRA_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"), PathBuf::from);
    let path = base.join(folder);
    if path.is_dir() {
        return Some(path);
    }
    left_out(&format!("{} is absent; set ADUMBRA_SHARED", path.display()), "ADUMBRA_REQUIRE_SHARED");
    None
}

/// Notes that a test is left out, for a reason: prints it, and adds a line to the file that `ADUMBRA_LEFT_OUT` names, which
/// `cargo xtask test` counts.
///
/// # Panics
/// Panics if the environment variable `required` is set.
pub fn left_out(reason: &str, required: &str) {
    assert!(std::env::var_os(required).is_none(), "{reason}, and {required} is set");
    eprintln!("LEFT OUT: {reason}");
    let Some(list) = std::env::var_os("ADUMBRA_LEFT_OUT") else { return };
    let test = std::env::var("NEXTEST_TEST_NAME").ok();
    let test = test.unwrap_or_else(|| std::thread::current().name().unwrap_or("a test").to_owned());
    let file = std::fs::OpenOptions::new().append(true).create(true).open(list);
    let written = file.and_then(|mut file| file.write_all(format!("{test}: {reason}\n").as_bytes()));
    written.expect("the list of tests that are left out can be written");
}

/// Whether `ADUMBRA_FULL` asks for the full size.
pub fn full() -> bool {
    std::env::var_os("ADUMBRA_FULL").is_some()
}

/// Returns the path of the scene with that name, whatever its extension. Panics if there is none.
pub fn scene_file(scenes: &Path, name: &str) -> PathBuf {
    let candidates = ["glb", "ply", "obj"].map(|e| scenes.join(format!("{name}.{e}")));
    candidates.into_iter().find(|p| p.exists()).unwrap_or_else(|| panic!("no scene for {name}"))
}
