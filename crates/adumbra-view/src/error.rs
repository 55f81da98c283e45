//! What may go wrong with a view as a whole; what goes wrong inside it is shown in the window, which stays.

use std::path::PathBuf;

use adumbra_render::RenderError;

/// An error of a view.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// No window can be opened.
    #[error(
        "no window can be opened: {reason}; a display is needed (DISPLAY or WAYLAND_DISPLAY on Linux), a virtual one will do (Xvfb)"
    )]
    Window {
        /// What the system says.
        reason: String,
    },
    /// What a view was asked to begin with does not exist.
    #[error("{what}")]
    Options {
        /// What is wrong.
        what: String,
    },
    /// The first scene cannot be loaded.
    #[error("{what}")]
    Scene {
        /// What is wrong.
        what: String,
    },
    /// A script that cannot be played.
    #[error("{}: {what}", path.display())]
    Script {
        /// The script.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// A step of a script that did not come to its end.
    #[error("{}: step {step} ({text}): {what}", path.display())]
    Step {
        /// The script.
        path: PathBuf,
        /// Number of the step, from 1.
        step: usize,
        /// The step, as JSON.
        text: String,
        /// What went wrong.
        what: String,
    },
    /// The library.
    #[error(transparent)]
    Library(#[from] adumbra::Error),
    /// The device.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// Of this crate.
pub type Result<T, E = ViewError> = std::result::Result<T, E>;
