//! Scripts: commands from a file, executed one after the other as if a user had given them.
//!
//! A script is a JSON array of steps. A step is a [`Command`], or a wait:
//!
//! ```json
//! [{"wait": "baked"}, {"layer": "shadow"}, {"key": "t"}, {"wait": {"frames": 2}},
//!  {"screenshot": "shadow.png"}, "quit"]
//! ```

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::time::Duration;

use adumbra_files::{TEXT_BYTES, read_text};

use serde::{Deserialize, Serialize};

use crate::command::Command;
use crate::error::{Result, ViewError};

/// Longest time that a step may wait.
pub(crate) const TIMEOUT: Duration = Duration::from_secs(600);

/// A condition that a script waits for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Until {
    /// The scene is loaded.
    Loaded,
    /// No bake is running, and the shadow file in use was baked for the current sun.
    Baked,
    /// At least one level of the bake is complete.
    Landed,
    /// The last frame had all that its camera needs of a streamed file.
    Streamed,
    /// The requested rays are traced.
    Traced,
    /// The ball has its path.
    Ball,
    /// This many frames were drawn since the previous step.
    Frames(u32),
    /// The picture has this width and height, in pixels.
    Size([u32; 2]),
    /// A message that contains this text was shown.
    Message(String),
    /// This many seconds passed.
    Seconds(f64),
}

/// A step of a script.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ScriptStep {
    /// Waits for a condition.
    Wait {
        /// The condition.
        wait: Until,
    },
    /// Executes a command.
    Do(Command),
}

/// The remaining steps of a script.
#[derive(Clone, Debug)]
pub struct Script {
    path: PathBuf,
    steps: VecDeque<ScriptStep>,
    done: usize,
}

impl Script {
    /// Reads a script.
    ///
    /// # Errors
    /// Returns [`ViewError::Io`] if the file cannot be read, or [`ViewError::Script`], with the number of the
    /// step, if it is not a script.
    pub fn read(path: &Path) -> Result<Self> {
        let text = read_text(path, TEXT_BYTES)?;
        Self::parse(path, &text)
    }

    fn parse(path: &Path, text: &str) -> Result<Self> {
        let wrong = |what: String| ViewError::Script { path: path.to_owned(), what };
        let values: Vec<serde_json::Value> =
            serde_json::from_str(text).map_err(|e| wrong(format!("not an array of steps: {e}")))?;
        let step = |(number, value): (usize, serde_json::Value)| {
            // Selected by its key, so that the error is about the step itself.
            let read = match value.get("wait") {
                Some(until) => serde_json::from_value(until.clone()).map(|wait| ScriptStep::Wait { wait }),
                None => serde_json::from_value(value.clone()).map(ScriptStep::Do),
            };
            read.map_err(|e| wrong(format!("step {}, {value}: {e}", number + 1)))
        };
        let steps: VecDeque<ScriptStep> = values.into_iter().enumerate().map(step).collect::<Result<_>>()?;
        let most = TIMEOUT.as_secs();
        let is_too_long = |step: &ScriptStep| match step {
            ScriptStep::Wait { wait: Until::Seconds(seconds) } => {
                !(0.0..=TIMEOUT.as_secs_f64()).contains(seconds)
            }
            _ => false,
        };
        if let Some(at) = steps.iter().position(is_too_long) {
            return Err(wrong(format!("step {}: give 0 to {most} seconds", at + 1)));
        }
        Ok(Self { path: path.to_owned(), steps, done: 0 })
    }

    /// Returns the next step.
    pub(crate) fn next(&self) -> Option<&ScriptStep> {
        self.steps.front()
    }

    /// Moves on to the step after it.
    pub(crate) fn advance(&mut self) {
        self.steps.pop_front();
        self.done += 1;
    }

    /// Returns an error for the next step.
    pub(crate) fn fault(&self, what: String) -> ViewError {
        let text = self.next().and_then(|s| serde_json::to_string(s).ok()).unwrap_or_default();
        ViewError::ScriptStep { path: self.path.clone(), step: self.done + 1, text, what }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::Side;

    fn parse(text: &str) -> Result<Script> {
        Script::parse(Path::new("s.json"), text)
    }

    #[test]
    fn script_round_trips() {
        let text = r#"[{"wait":"baked"},{"wait":{"frames":2}},{"wait":{"message":"no"}},{"layer":"shadow"},
            {"shadow":{"side":"second","technique":"csm"}},{"split":0.25},{"resize":[640,480]},"quit"]"#;
        let script = parse(text).unwrap();
        let commands: Vec<&ScriptStep> = script.steps.iter().collect();
        assert_eq!(commands.len(), 8);
        assert_eq!(*commands[1], ScriptStep::Wait { wait: Until::Frames(2) });
        let csm = Command::Shadow { side: Side::Second, technique: "csm".to_owned() };
        assert_eq!(*commands[4], ScriptStep::Do(csm));
        assert_eq!(*commands[7], ScriptStep::Do(Command::Quit));
        let again = serde_json::to_string(&script.steps).unwrap();
        assert_eq!(parse(&again).unwrap().steps, script.steps);
    }

    #[test]
    fn script_error_names_the_step() {
        for (text, fault) in [
            ("{}", "not an array"),
            (r#"["quit", {"lair": "shadow"}]"#, "step 2"),
            (r#"[{"wait": "forever"}]"#, "step 1"),
            (r#"[{"wait": "forever"}]"#, "forever"),
            (r#"[{"split": "half"}]"#, "half"),
            (r#"["quit", {"wait": {"seconds": 700}}]"#, "step 2: give 0 to 600"),
        ] {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.contains(fault), "{error}");
        }
        let mut script = parse(r#"["quit", {"layer": "ao"}]"#).unwrap();
        script.advance();
        let error = script.fault("too slow".to_owned()).to_string();
        assert!(error.contains("step 2") && error.contains("ao") && error.contains("too slow"), "{error}");
    }
}
