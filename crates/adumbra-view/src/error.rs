//! Errors that end a view. All others are shown in the window, which stays open.

use std::path::PathBuf;

use adumbra::IoError;
use adumbra_render::RenderError;

/// An error of a view.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// No window can be opened.
    #[error(
        "cannot open a window: {reason}; a display is needed (DISPLAY or WAYLAND_DISPLAY on Linux), and a virtual one such as Xvfb is enough"
    )]
    Window {
        /// The system's message.
        reason: String,
    },
    /// Some of the options are invalid or inconsistent.
    #[error("{what}")]
    Options {
        /// The affected option.
        field: OptionField,
        /// What is wrong.
        what: String,
    },
    /// The first scene cannot be loaded.
    #[error(transparent)]
    Scene(#[from] adumbra_scene::Error),
    /// Work on another thread failed unexpectedly.
    #[error("{what}")]
    Fault {
        /// Description of the fault.
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
    /// A step of a script failed or was not completed.
    #[error("{}: step {step} ({text}): {what}", path.display())]
    ScriptStep {
        /// The script.
        path: PathBuf,
        /// Number of the step, from 1.
        step: usize,
        /// The step, as JSON.
        text: String,
        /// What went wrong.
        what: String,
    },
    /// A file cannot be read.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A shadow file cannot be read, or a sun is not valid.
    #[error(transparent)]
    Library(#[from] adumbra::Error),
    /// An error of the device.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// The field of [`ViewOptions`](crate::ViewOptions) that an error concerns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum OptionField {
    /// The shadow techniques.
    Shadows,
    /// Ambient occlusion.
    Ambient,
    /// The layer.
    Layer,
    /// The way both sides are shown.
    Shown,
    /// The camera's eye and target.
    EyeAndTarget,
    /// The camera's target.
    Target,
    /// The time in seconds since all movements began.
    Seconds,
    /// Samples per pixel.
    Antialias,
    /// Resolution of bakes, in texels.
    Resolution,
    /// Budget of shadow files.
    Budget,
    /// The day to play.
    Day,
}

/// Result type used across the crate.
pub type Result<T, E = ViewError> = std::result::Result<T, E>;
