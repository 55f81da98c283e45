//! Scenes and shadow files, read on another thread.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use adumbra::files::folder_of;
use adumbra::format::AnyFile;
use adumbra::scene::{self, LoadOptions, Scene};

use crate::background::in_background;
use crate::news::{News, Teller};

/// A scene, apart from what moves.
pub(crate) struct LoadedScene {
    pub(crate) path: PathBuf,
    /// Differs from scene to scene.
    pub(crate) number: u64,
    /// Everything, for rays.
    pub(crate) whole: Arc<Scene>,
    /// What stands still.
    pub(crate) still: Arc<Scene>,
    /// What moves.
    pub(crate) moving: Scene,
    /// [`Scene::usual_diagonal`].
    pub(crate) usual_diagonal_world: f64,
    /// Take masked materials as opaque.
    pub(crate) ignore_alpha: bool,
    /// What the loader noticed.
    pub(crate) notes: Vec<String>,
    /// The files that it names.
    pub(crate) named_files: Vec<PathBuf>,
}

/// What a path may be dropped as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DropKind {
    Scene,
    ShadowFile,
    Camera,
}

/// What a file is, by its ending.
pub(crate) fn drop_kind(path: &Path) -> Result<DropKind, String> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    Ok(match ending.as_str() {
        "glb" | "gltf" | "obj" | "ply" => DropKind::Scene,
        "adumbra" => DropKind::ShadowFile,
        "json" => DropKind::Camera,
        _ => {
            return Err(format!(
                "{}: drop a scene (.glb, .gltf, .obj, .ply), a shadow file (.adumbra) or a camera (.json)",
                path.display()
            ));
        }
    })
}

impl LoadedScene {
    /// Takes a scene that was loaded with its movers kept.
    pub(crate) fn new(path: PathBuf, whole: Scene, ignore_alpha: bool) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        let mut notes: Vec<String> = whole.notes.warnings.iter().map(ToString::to_string).collect();
        if whole.notes.degenerate_triangles > 0 {
            notes.push(format!("{} degenerate triangles skipped", whole.notes.degenerate_triangles));
        }
        if whole.notes.untriangulated_polygons > 0 {
            let count = whole.notes.untriangulated_polygons;
            notes.push(format!("{count} polygons could not be triangulated properly"));
        }
        let folder = folder_of(&path);
        let named_files = whole.notes.named_files.iter().map(|name| folder.join(name)).collect();
        let usual_diagonal_world = whole.usual_diagonal();
        let whole = Arc::new(whole);
        let (still, moving) = if whole.movers.is_empty() {
            (whole.clone(), Scene::default())
        } else {
            let mut still = (*whole).clone();
            let moving = still.take_movers();
            (Arc::new(still), moving)
        };
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        Self { path, number, whole, still, moving, usual_diagonal_world, ignore_alpha, notes, named_files }
    }
}

/// Scenes that are under way, by number. What was asked for later is shown, as long as it comes at all: one that fails takes nothing away.
#[derive(Default)]
pub(crate) struct Loads {
    under_way: BTreeMap<u64, PathBuf>,
    begun: u64,
    shown: u64,
}

impl Loads {
    /// The number of the scene that a view begins with.
    pub(crate) const FIRST: u64 = 1;

    /// Another one is under way; gives its number.
    pub(crate) fn begin(&mut self, path: PathBuf) -> u64 {
        self.begun += 1;
        self.under_way.insert(self.begun, path);
        self.begun
    }

    /// The one asked for last.
    pub(crate) fn newest(&self) -> Option<&Path> {
        self.under_way.values().next_back().map(PathBuf::as_path)
    }

    pub(crate) fn are_done(&self) -> bool {
        self.under_way.is_empty()
    }

    /// One has come; whether it is to be shown.
    pub(crate) fn came(&mut self, load: u64) -> bool {
        self.under_way.retain(|other, _| *other > load);
        let is_newer = load > self.shown;
        self.shown = self.shown.max(load);
        is_newer
    }

    /// One will not come.
    pub(crate) fn failed(&mut self, load: u64) {
        self.under_way.remove(&load);
    }
}

/// Loads a scene; the number comes back with it.
pub(crate) fn load_scene(load: u64, path: PathBuf, options: LoadOptions, teller: Teller) {
    let work = move || {
        let scene = scene::load(&path, &options).map_err(|e| e.to_string())?;
        Ok(Arc::new(LoadedScene::new(path, scene, options.ignore_alpha)))
    };
    in_background(teller, work, move |loaded| News::Scene { load, loaded });
}

/// Reads a shadow file.
pub(crate) fn read_file(path: PathBuf, teller: Teller) {
    let file = path.clone();
    let work = move || AnyFile::read(&file).map_err(|e| e.to_string());
    in_background(teller, work, |read| News::File { path, read });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn newest_scene_that_comes_is_shown() {
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
    fn drop_is_told_by_its_ending() {
        let kind = |name: &str| drop_kind(Path::new(name));
        assert_eq!(kind("a/City.GLB"), Ok(DropKind::Scene));
        assert_eq!(kind("city.adumbra"), Ok(DropKind::ShadowFile));
        assert_eq!(kind("view.json"), Ok(DropKind::Camera));
        assert!(kind("notes.txt").unwrap_err().contains("notes.txt"));
        assert!(kind("noending").is_err());
    }
}
