//! What a user may do, whatever it comes from: the mouse, a key, the panel, a dropped file, or a line of a script.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// One of the two techniques that are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The one shown alone, or on the left.
    First,
    /// The one on the right.
    Second,
}

/// A change of what is shown, or something to be done with it. As JSON it is an object with one key, such as `{"layer": "shadow"}`, or
/// the name alone where there is nothing to say, such as `"quit"`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Command {
    /// Another shadow technique, as `--shadow` names it.
    Shadow {
        /// Of which side.
        side: Side,
        /// `NAME[:KEY=VALUE…]`.
        technique: String,
    },
    /// The technique so many places further in the list of all, on a side.
    NextShadow {
        /// Of which side.
        side: Side,
        /// Places; back below 0.
        by: i32,
    },
    /// Other ambient occlusion, as `--ao` names it.
    Ao(String),
    /// The ambient occlusion so many places further.
    NextAo(i32),
    /// Another layer, as `--layer` names it.
    Layer(String),
    /// The layer so many places further.
    NextLayer(i32),
    /// Each side shows what the other did.
    ChangeSides,
    /// The first technique alone.
    Single,
    /// Both, the divider at this share of the width.
    Split(f64),
    /// Where they differ, multiplied by this.
    Difference(f32),
    /// Where the sun stands, degrees.
    Sun {
        /// Clockwise from -Z, seen from above.
        azimuth: f64,
        /// Above the horizon.
        elevation: f64,
    },
    /// Moves the sun by degrees.
    TurnSun {
        /// Clockwise.
        azimuth: f64,
        /// Up.
        elevation: f64,
    },
    /// Where the camera stands and looks.
    Camera {
        /// World position.
        eye: [f64; 3],
        /// World point in the middle of the view.
        target: [f64; 3],
        /// Vertical field of view, degrees; as it was where it is absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        fov: Option<f64>,
    },
    /// The camera of a file that a view or a person wrote.
    LoadCamera(PathBuf),
    /// Around the target: degrees to the right and up.
    Orbit([f64; 2]),
    /// The target around the eye: degrees to the right and up.
    Look([f64; 2]),
    /// Eye and target aside: shares of what is seen of the target's plane, to the right and up.
    Pan([f64; 2]),
    /// To the right, up and ahead, in distances from the target.
    Fly([f64; 3]),
    /// Nearer by a factor below 1, further by one above.
    Zoom(f64),
    /// The camera that the view began with.
    ResetCamera,
    /// The sun that the view began with.
    ResetSun,
    /// Everything as the view began with it.
    ResetAll,
    /// A ball that rolls from the sun into the shade, or none.
    Ball(bool),
    /// The camera that sees the ball's way.
    WatchBall,
    /// Seconds since all movements began.
    Time(f64),
    /// Whether time goes on.
    Play(bool),
    /// The space of the shadow file as a box of lines.
    Box(bool),
    /// The panel.
    Panel(bool),
    /// The help.
    Help(bool),
    /// Samples a pixel along each side.
    Antialias(u32),
    /// Frames drawn on and on, or only where something changed.
    Continuous(bool),
    /// Bakes anew, to so many texels on the longest side; a world-aligned file to 2048 at most.
    Bake(u64),
    /// Stops the bake; what landed stays.
    CancelBake,
    /// A scene, a shadow file or a camera, as if it were dropped on the window.
    Drop(PathBuf),
    /// The size of what is shown, pixels.
    Resize([u32; 2]),
    /// Writes what is shown, without the panel, as PNG.
    Screenshot(PathBuf),
    /// Writes the whole window with the panel as PNG, when it is drawn next.
    WindowShot(PathBuf),
    /// Writes the camera as JSON that `compare --camera` takes.
    SaveCamera(PathBuf),
    /// A key, as the keyboard names it: `t`, `T`, `?`, `F12`, `Space`.
    Key(String),
    /// Says the command that shows this view again.
    SayLine,
    /// Closes the window.
    Quit,
}
