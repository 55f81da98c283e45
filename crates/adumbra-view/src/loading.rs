//! Reads scenes and shadow files on another thread.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use adumbra::stream::StreamOptions;
use adumbra_scene as scene;
use adumbra_scene::LoadOptions;

use crate::background::in_background;
use crate::error::ViewError;
use crate::event::{Event, EventSender};
use crate::loaded_scene::LoadedScene;
use crate::shadow_file::ShownFile;

/// The kind of a dropped file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DropKind {
    Scene,
    ShadowFile,
    Camera,
}

/// Returns the kind of a file, by its extension.
pub(crate) fn drop_kind(path: &Path) -> Result<DropKind, String> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    Ok(match ending.as_str() {
        "glb" | "gltf" | "obj" | "ply" => DropKind::Scene,
        "adumbra" => DropKind::ShadowFile,
        "json" => DropKind::Camera,
        _ => {
            return Err(format!(
                "{}: unknown kind of file; drop a scene (.glb, .gltf, .obj, .ply), a shadow file (.adumbra) or a camera (.json)",
                path.display()
            ));
        }
    })
}

/// Scenes being loaded, by number. A scene replaces those that were requested before it; one that fails
/// replaces nothing.
#[derive(Default)]
pub(crate) struct Loads {
    under_way: BTreeMap<u64, PathBuf>,
    begun: u64,
    shown: u64,
}

impl Loads {
    /// Number of the scene that a view starts with.
    pub(crate) const FIRST: u64 = 1;

    /// Registers another load and returns its number.
    pub(crate) fn begin(&mut self, path: PathBuf) -> u64 {
        self.begun += 1;
        self.under_way.insert(self.begun, path);
        self.begun
    }

    /// Returns the path of the scene requested last.
    pub(crate) fn newest(&self) -> Option<&Path> {
        self.under_way.values().next_back().map(PathBuf::as_path)
    }

    pub(crate) fn are_done(&self) -> bool {
        self.under_way.is_empty()
    }

    /// Registers a scene that was loaded. Returns whether it is to be shown.
    pub(crate) fn came(&mut self, load: u64) -> bool {
        self.under_way.retain(|other, _| *other > load);
        let is_newer = load > self.shown;
        self.shown = self.shown.max(load);
        is_newer
    }

    /// Registers a load that failed.
    pub(crate) fn failed(&mut self, load: u64) {
        self.under_way.remove(&load);
    }
}

/// Loads a scene and sends it with the number of its load.
pub(crate) fn load_scene(load: u64, path: PathBuf, options: LoadOptions, sender: EventSender) {
    let work = move || {
        let scene = scene::load(&path, &options);
        Ok(scene.map(|scene| Arc::new(LoadedScene::new(path, scene, options.ignore_alpha))))
    };
    in_background(work, move |done| {
        let loaded = match done {
            Ok(loaded) => loaded.map_err(ViewError::from),
            Err(what) => Err(ViewError::Fault { what }),
        };
        sender.send(Event::Scene { load, loaded });
    });
}

/// Reads a shadow file, or the beginning of one that needs more than the budget, and sends it.
pub(crate) fn read_file(path: PathBuf, stream: StreamOptions, sender: EventSender) {
    let file = path.clone();
    let work = move || ShownFile::read(&file, stream).map_err(|e| e.to_string());
    in_background(work, move |read| sender.send(Event::File { path, read }));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shows_the_newest_scene_that_loads() {
        let mut loads = Loads::default();
        let [a, b, c] = ["a", "b", "c"].map(|path| loads.begin(path.into()));
        assert_eq!((a, loads.newest()), (Loads::FIRST, Some(Path::new("c"))));
        loads.failed(c);
        assert_eq!(loads.newest(), Some(Path::new("b")));
        assert!(loads.came(b) && loads.are_done());
        assert!(!loads.came(a), "b was asked for later");
        let d = loads.begin("d".into());
        assert!(loads.came(d) && loads.are_done());
    }

    #[test]
    fn dropped_files_are_recognized_by_extension() {
        let kind = |name: &str| drop_kind(Path::new(name));
        assert_eq!(kind("a/City.GLB"), Ok(DropKind::Scene));
        assert_eq!(kind("city.adumbra"), Ok(DropKind::ShadowFile));
        assert_eq!(kind("view.json"), Ok(DropKind::Camera));
        assert!(kind("notes.txt").unwrap_err().contains("notes.txt"));
        assert!(kind("noending").is_err());
    }
}
