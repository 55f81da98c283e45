//! Events that other threads send to the window.

use std::path::PathBuf;
use std::sync::Arc;

use adumbra::ShadowFile;
use adumbra_truth::movers::BallPath;

use crate::error::Result;
use crate::loaded_scene::LoadedScene;
use crate::shadow_file::ShownFile;
use crate::traced::Traced;

/// An event from another thread.
pub(crate) enum Event {
    /// A loaded scene, or the error; `load` is the number of the load.
    Scene { load: u64, loaded: Result<Arc<LoadedScene>> },
    /// Some of the watched files have changed.
    Changed,
    /// A shadow file that was read, or the error.
    File { path: PathBuf, read: Result<ShownFile, String> },
    /// Progress of a bake, identified by its number: texels on the longest side, and the completed fraction.
    Baking { bake: u64, resolution: u64, share: f32 },
    /// A completed level of a bake.
    Baked { bake: u64, file: Box<ShadowFile>, last: bool },
    /// A key of a day has been baked or read.
    Key,
    /// A bake ended without a file: it was cancelled, or failed with this error.
    BakeEnded { bake: u64, error: Option<String> },
    /// Traced visibilities.
    Traced(Traced),
    /// Rays could not be traced, for this reason.
    NotTraced { error: String },
    /// The ball's path in a scene, with the eye and target of a camera that sees it.
    Ball { scene: u64, found: Result<(BallPath, [[f64; 3]; 2]), String> },
}

/// Sends events to the window from any thread.
#[derive(Clone)]
pub(crate) struct EventSender(Arc<dyn Fn(Event) + Send + Sync>);

impl EventSender {
    pub(crate) fn new(send: impl Fn(Event) + Send + Sync + 'static) -> Self {
        Self(Arc::new(send))
    }

    pub(crate) fn send(&self, event: Event) {
        (self.0)(event);
    }
}
