//! A scene as the view uses it: the whole scene, its moving part and its static part.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use adumbra_files::folder_of;
use adumbra_scene::Scene;

/// A scene, split into its moving and its static part.
pub(crate) struct LoadedScene {
    pub(crate) path: PathBuf,
    /// Unique number of the scene.
    pub(crate) number: u64,
    /// The whole scene, for ray tracing.
    pub(crate) whole: Arc<Scene>,
    /// The static part.
    pub(crate) still: Arc<Scene>,
    /// The moving part.
    pub(crate) moving: Scene,
    /// [`Scene::usual_diagonal`].
    pub(crate) usual_diagonal_world: f64,
    /// Whether masked materials are treated as opaque.
    pub(crate) ignore_alpha: bool,
    /// The loader's notes.
    pub(crate) notes: Vec<String>,
    /// The files that the scene refers to.
    pub(crate) named_files: Vec<PathBuf>,
}

impl LoadedScene {
    /// Splits a scene that was loaded with its movers.
    pub(crate) fn new(path: PathBuf, whole: Scene, ignore_alpha: bool) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        let mut notes: Vec<String> = whole.notes.warnings.iter().map(ToString::to_string).collect();
        notes.extend(whole.notes.omissions.iter().map(|omission| format!("{omission} left out")));
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
