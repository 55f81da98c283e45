//! Crates of this repository use hidden items of each other, which may change with every release. So each
//! asks for exactly the version of the others that it was made with.

use std::fs;
use std::path::Path;

/// Manifests with dependencies that are published.
const MANIFESTS: [&str; 2] = ["Cargo.toml", "integrations/bevy_adumbra/Cargo.toml"];

#[test]
fn siblings_are_pinned_to_one_version() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the folder of the workspace");
    let mut pinned = 0;
    for name in MANIFESTS {
        let manifest = fs::read_to_string(root.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        for line in manifest.lines().filter(|line| line.starts_with("adumbra") && line.contains("version")) {
            assert!(line.contains("version = \"="), "{name}: {line}: write version = \"=…\"");
            pinned += 1;
        }
    }
    assert!(pinned > 10, "{pinned}");
}
