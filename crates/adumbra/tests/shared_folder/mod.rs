//! Where the tests find scenes and truth that are no part of the repository: `ADUMBRA_SHARED`, or `shared` beside the
//! checkout. `ADUMBRA_FULL=1` asks for their full size.

#![allow(dead_code, reason = "each test program uses a part")]

use std::path::{Path, PathBuf};

/// A folder of it; where it is absent that is said, and the test should pass.
pub(crate) fn shared(folder: &str) -> Option<PathBuf> {
    let base = std::env::var_os("ADUMBRA_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"), PathBuf::from);
    let path = base.join(folder);
    if !path.is_dir() {
        eprintln!("SKIPPED: {} is absent; set ADUMBRA_SHARED", path.display());
        return None;
    }
    Some(path)
}

/// Whether the full size was asked for.
pub(crate) fn full() -> bool {
    std::env::var_os("ADUMBRA_FULL").is_some()
}

/// The scene file of that name, whatever its ending.
pub(crate) fn scene_file(scenes: &Path, name: &str) -> PathBuf {
    let candidates = ["glb", "ply", "obj"].map(|e| scenes.join(format!("{name}.{e}")));
    candidates.into_iter().find(|p| p.exists()).unwrap_or_else(|| panic!("no scene for {name}"))
}
