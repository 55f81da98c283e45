//! A user's commands, whatever their source: the mouse, a key, the panel, a dropped file, or a line of a
//! script.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// One of the two techniques being compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The technique that is shown alone or on the left.
    First,
    /// The technique on the right.
    Second,
}

/// A change of what is shown, or an action. As JSON it is an object with one key, such as
/// `{"layer": "shadow"}`, or just the name if there are no arguments, such as `"quit"`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Command {
    /// Selects a shadow technique by its name in `--shadow`.
    Shadow {
        /// The side to change.
        side: Side,
        /// `NAME[:KEY=VALUE…]`.
        technique: String,
    },
    /// Moves a side's technique this many positions forward in the list of all techniques.
    NextShadow {
        /// The side to change.
        side: Side,
        /// Number of positions; negative moves back.
        by: i32,
    },
    /// Selects an ambient occlusion technique by its name in `--ao`.
    Ao(String),
    /// Moves the ambient occlusion technique this many positions forward.
    NextAo(i32),
    /// Selects a layer by its name in `--layer`.
    Layer(String),
    /// Moves the layer this many positions forward.
    NextLayer(i32),
    /// Swaps the techniques of the two sides.
    ChangeSides,
    /// Shows the first technique alone.
    Single,
    /// Shows both techniques, with the divider at this fraction of the width.
    Split(f64),
    /// Shows the difference of the two, multiplied by this gain.
    Difference(f32),
    /// Sets the sun's azimuth and elevation, in degrees.
    Sun {
        /// Azimuth clockwise from -Z, seen from above.
        azimuth: f64,
        /// Elevation above the horizon.
        elevation: f64,
    },
    /// Moves the sun by these angles, in degrees.
    TurnSun {
        /// Change of the azimuth, clockwise.
        azimuth: f64,
        /// Change of the elevation, upwards.
        elevation: f64,
    },
    /// Sets the camera's position and target.
    Camera {
        /// World position.
        eye: [f64; 3],
        /// World point at the centre of the view.
        target: [f64; 3],
        /// Vertical field of view in degrees; unchanged if absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        fov: Option<f64>,
    },
    /// Loads the camera of a file that was saved by a view or written by hand.
    LoadCamera(PathBuf),
    /// Moves the eye around the target: degrees to the right and up.
    Orbit([f64; 2]),
    /// Moves the target around the eye: degrees to the right and up.
    Look([f64; 2]),
    /// Moves eye and target to the right and up, in fractions of the visible height at the target.
    Pan([f64; 2]),
    /// Moves eye and target to the right, up and ahead, in distances from eye to target.
    Fly([f64; 3]),
    /// Zooms in by a factor below 1, out by a factor above 1.
    Zoom(f64),
    /// Restores the camera that the view started with.
    ResetCamera,
    /// Restores the sun that the view started with.
    ResetSun,
    /// Restores all settings that the view started with.
    ResetAll,
    /// Adds or removes a ball that rolls from sunlight into shadow.
    Ball(bool),
    /// Selects a camera that sees the ball's path.
    WatchBall,
    /// Sets the time, in seconds since all movements began.
    Time(f64),
    /// Sets the clock of the day that is played, in hours.
    Hour(f64),
    /// Starts or stops time.
    Play(bool),
    /// Shows or hides the bounds of the shadow file's space as lines.
    Box(bool),
    /// Shows or hides the panel.
    Panel(bool),
    /// Shows or hides the help.
    Help(bool),
    /// Sets the samples per pixel along each side.
    Antialias(u32),
    /// Draws frames continuously, or only when something changed.
    Continuous(bool),
    /// Starts a new bake with this many texels on the longest side.
    Bake(u64),
    /// Sets the budget of shadow files in MiB: a file that needs more is streamed.
    Budget(u64),
    /// Stops the bake; completed levels stay.
    CancelBake,
    /// Opens a scene, a shadow file or a camera, as if it were dropped on the window.
    Drop(PathBuf),
    /// Sets the size of the picture, in pixels.
    Resize([u32; 2]),
    /// Writes a PNG of the picture, without the panel.
    Screenshot(PathBuf),
    /// Writes a PNG of the whole window with the panel, when it is drawn next.
    WindowShot(PathBuf),
    /// Writes the camera as JSON, for `compare --camera`.
    SaveCamera(PathBuf),
    /// Presses a key, as the keyboard names it: `t`, `T`, `?`, `F12`, `Space`.
    Key(String),
    /// Reports the command line that reproduces this view.
    SayLine,
    /// Closes the window.
    Quit,
}
