//! The files that a glTF scene names: its buffers and images.

use std::path::{Path, PathBuf};

use ::gltf::json::Root;

use super::container::split;
use super::document::GltfDocument;
use super::uris;
use crate::sources::{Sources, leaves};
use crate::{LoadOptions, Result};

/// The URIs of all buffers and images that are separate files.
fn uris(root: &Root) -> impl Iterator<Item = &str> {
    let buffers = root.buffers.iter().filter_map(|b| b.uri.as_deref());
    let images = root.images.iter().filter_map(|i| i.uri.as_deref());
    buffers.chain(images).filter(|uri| !uri.starts_with("data:"))
}

/// The files of all buffers and images, relative to the scene, with names decoded according to the
/// specification.
pub(super) fn named(root: &Root) -> impl Iterator<Item = String> {
    uris(root).filter_map(|uri| uris::names(uri).into_iter().next())
}

/// Returns the files that a glTF scene names in its folder, sorted, with paths relative to it: buffers and
/// images, whether [`load`](crate::load) needs them or not. For programs that fetch a scene from elsewhere.
/// `bytes` is the content of a `.glb` or `.gltf`, and `path` is its name. Files outside the folder are left
/// out.
///
/// # Errors
/// Returns [`Error::SceneParse`](crate::Error::SceneParse) if the container or the JSON is broken,
/// [`Error::GltfVersion`](crate::Error::GltfVersion) and [`Error::SceneMemory`](crate::Error::SceneMemory).
pub fn files_of_gltf(path: &Path, bytes: &[u8]) -> Result<Vec<PathBuf>> {
    let sources = Sources::new(path, "glTF", &LoadOptions::default());
    sources.budget.allow_for(bytes.len() as u64);
    let root = GltfDocument::parse(path, split(path, bytes)?.json, &sources.budget)?.root;
    let paths = named(&root).map(|name| PathBuf::from(name.replace('\\', "/")));
    let mut paths: Vec<PathBuf> = paths.filter(|path| !leaves(path)).collect();
    paths.sort_unstable();
    paths.dedup();
    Ok(paths)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_only_files_inside_the_folder() {
        let json = br#"{"asset": {"version": "2.0"}, "buffers": [{"uri": "b%20c.bin", "byteLength": 1},
            {"uri": "data:;base64,AA==", "byteLength": 1}, {"byteLength": 1}],
            "images": [{"uri": "../a.png"}, {"uri": "/a.png"}, {"uri": "t/a.png"}, {"uri": "t/a.png"}]}"#;
        let files = files_of_gltf(Path::new("s.gltf"), json).unwrap();
        assert_eq!(files, [Path::new("b c.bin"), Path::new("t/a.png")]);
        assert!(files_of_gltf(Path::new("s.glb"), json).is_err());
        assert!(files_of_gltf(Path::new("s.gltf"), b"{").is_err());
    }
}
