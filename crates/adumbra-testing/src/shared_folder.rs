//! The folder of scenes and truth that are not part of the repository: `ADUMBRA_SHARED`, or `shared` next to
//! the checkout. `ADUMBRA_FULL=1` makes the tests use them at full size.

use std::path::{Path, PathBuf};

/// Returns a folder in the shared folder. If it is absent, the test should pass: it is left out, see
/// [`left_out`](crate::left_out).
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
    crate::left_out(&format!("{} is absent; set ADUMBRA_SHARED", path.display()), "ADUMBRA_REQUIRE_SHARED");
    None
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
