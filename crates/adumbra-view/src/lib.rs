//! A window that shows a scene: every shadow and ambient-occlusion technique, two of them side by side or
//! their difference, the layers of a frame, and a background bake whenever the sun moves.
//!
//! [`run`] opens it. Mouse, keys, the panel, dropped files and a [`Script`] all produce a
//! [`Command`]. Commands change [`Settings`], which are plain data. Anything that is not a setting, such as a
//! screenshot, is done by `App`.
//!
//! # From settings to a frame
//!
//! Before each frame the view compares its state with what the settings require. No part is notified of
//! changes.
//!
//! - `Stage` keeps the scene on the device and rebuilds a technique if it is not the requested one.
//! - `Shadows` starts and cancels bakes until the shadow file in use matches the current sun. A given file is
//!   preferred to a bake.
//! - `TraceThread` traces the rays of the current camera if a technique uses them. A new request cancels the
//!   previous one.
//!
//! The second side is drawn with the G-buffer and the ambient occlusion of the first.
//! `adumbra_render::layers` makes a display-encoded picture of one layer of each side, draws both to the
//! window, at a divider or as their difference, and draws lines over them. A screenshot is that picture
//! without the panel. For the same settings it equals the picture of `adumbra render`. The program's tests
//! compare both, layer by layer.
//!
//! # Threads
//!
//! Scenes and shadow files are loaded, shadows baked, rays traced and the ball's path found on other threads.
//! They send an `Event` to the window's loop. Scenes and bakes have numbers, and traced pictures have a key,
//! so that outdated results are dropped. A panic on such a thread becomes an error message, and the window
//! stays open.
//!
//! # Modules
//!
//! | file | contents |
//! |---|---|
//! | `settings`, `command`, `keys`, `navigation` | what is shown, and what changes it, without a window or a device |
//! | `script`, `player` | commands from a file, one after the other |
//! | `background`, `event` | threads, and the events that they send |
//! | `loading`, `baking`, `tracing`, `ball` | work on other threads; `loaded_scene` and `traced` are its results |
//! | `shadows`, `shadow_file` | starts and cancels bakes; reads properties of shadow files |
//! | `day` | plays a day: its clock, and the keys around its sun |
//! | `stage`, `wireframes` | draws what the settings require |
//! | `ui/`, `messages` | the panel, the plot of times, the help; messages to the user |
//! | `options`, `startup`, `command_line` | from options to the first settings, and from settings to a command line |
//! | `app`, `window` | the state of the view; the event loop |

mod app;
mod background;
mod baking;
mod ball;
mod command;
mod command_line;
mod day;
mod error;
mod event;
mod keys;
mod loaded_scene;
mod loading;
mod messages;
mod navigation;
mod options;
mod player;
mod script;
mod settings;
mod shadow_file;
mod shadows;
mod stage;
mod startup;
mod traced;
mod tracing;
mod ui;
mod window;
mod wireframes;

pub use command::{Command, Side};
pub use day::DayOptions;
pub use error::{OptionField, Result, ViewError};
pub use messages::Say;
pub use options::ViewOptions;
pub use script::{Script, ScriptStep, Until};
pub use settings::{Settings, Shown};
pub use window::run;
