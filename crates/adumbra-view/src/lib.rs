//! A window on a scene: every shadow and ambient-occlusion technique, two of them side by side or their difference, the layers of a
//! frame, and a bake in the background whenever the sun moves.
//!
//! [`run`] opens it. What a user may do is a [`Command`], whether it comes from the mouse, a key, the panel, a dropped file or a
//! [`Script`]; what is shown is [`Settings`], plain data that commands change; `stage` draws them, `baking`, `tracing` and `loading` work
//! on other threads and tell the window by `News`.
//!
//! | file | what |
//! |---|---|
//! | `settings`, `command`, `keys`, `navigation` | what is shown, what changes it, without a window or a device |
//! | `script`, `player` | commands from a file, one after the other |
//! | `loading`, `baking`, `tracing`, `ball` | work on other threads; `shadows` begins and ends bakes, `shadow_file` reads what files say |
//! | `stage` | draws what the settings say |
//! | `ui/` | the panel, the plot of times, the help |
//! | `beginning`, `app`, `window` | the loop of events that ties them together |

mod app;
mod background;
mod baking;
mod ball;
mod beginning;
mod boxes;
mod command;
mod command_line;
mod error;
mod keys;
mod loading;
mod messages;
mod navigation;
mod news;
mod options;
mod player;
mod script;
mod settings;
mod shadow_file;
mod shadows;
mod stage;
mod tracing;
mod ui;
mod window;

pub use command::{Command, Side};
pub use error::{Result, ViewError};
pub use messages::Say;
pub use options::ViewOptions;
pub use script::{Script, Step, Until};
pub use settings::{Settings, Shown};
pub use window::run;
