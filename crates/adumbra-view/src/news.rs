//! What other threads tell the window.

use std::path::PathBuf;
use std::sync::Arc;

use adumbra::format::AnyFile;
use adumbra_render::movers::BallPath;

use crate::loading::LoadedScene;
use crate::tracing::Traced;

/// One piece of news.
pub(crate) enum News {
    /// A scene, or what went wrong; the number is that of the load.
    Scene { load: u64, loaded: Result<Arc<LoadedScene>, String> },
    /// A shadow file, or what went wrong.
    File { path: PathBuf, read: Result<AnyFile, String> },
    /// Where a bake stands, by its number: texels on the longest side, and the share that is done.
    Baking { bake: u64, resolution: u64, share: f32 },
    /// A level of a bake.
    Baked { bake: u64, file: AnyFile, last: bool },
    /// A bake ended without a file: cancelled, or for this reason.
    BakeEnded { bake: u64, error: Option<String> },
    /// Rays.
    Traced(Traced),
    /// Rays that could not be.
    NotTraced { error: String },
    /// The ball's way in a scene, with the eye and target of a camera that sees it.
    Ball { scene: u64, found: Result<(BallPath, [[f64; 3]; 2]), String> },
}

/// Tells the window, from any thread.
#[derive(Clone)]
pub(crate) struct Teller(Arc<dyn Fn(News) + Send + Sync>);

impl Teller {
    pub(crate) fn new(tell: impl Fn(News) + Send + Sync + 'static) -> Self {
        Self(Arc::new(tell))
    }

    pub(crate) fn tell(&self, news: News) {
        (self.0)(news);
    }
}
