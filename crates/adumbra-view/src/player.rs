//! Plays a script: returns each command once the steps before it are done.

use std::collections::VecDeque;
use std::time::Instant;

use crate::command::Command;
use crate::error::{Result, ViewError};
use crate::script::{Script, ScriptStep, TIMEOUT, Until};

/// The state of the view that scripts can wait for.
pub(crate) struct Progress<'a> {
    pub(crate) is_loaded: bool,
    pub(crate) is_baked: bool,
    pub(crate) has_landed: bool,
    pub(crate) is_streaming: bool,
    pub(crate) is_traced: bool,
    pub(crate) is_playing: bool,
    pub(crate) has_ball: bool,
    pub(crate) seeks_ball: bool,
    pub(crate) size: [u32; 2],
    /// Why a bake that the script waits for failed.
    pub(crate) bake_fault: Option<&'a str>,
    /// Why rays that the script waits for failed.
    pub(crate) trace_fault: Option<&'a str>,
    /// Messages so far.
    pub(crate) messages: &'a VecDeque<String>,
}

pub(crate) struct Player {
    script: Script,
    /// When the next step was reached.
    since: Instant,
    /// Frames drawn since then.
    frames: u32,
}

impl Player {
    pub(crate) fn new(script: Script) -> Self {
        Self { script, since: Instant::now(), frames: 0 }
    }

    /// Returns the command to execute now; `None` if a wait is in progress or no step is left.
    ///
    /// # Errors
    /// Returns [`ViewError::ScriptStep`] if a wait took too long or can no longer succeed.
    pub(crate) fn next(&mut self, progress: &Progress<'_>) -> Result<Option<Command>> {
        while let Some(step) = self.script.next() {
            let until = match step {
                ScriptStep::Do(command) => return Ok(Some(command.clone())),
                ScriptStep::Wait { wait } => wait,
            };
            if *until == Until::Baked
                && let Some(fault) = progress.bake_fault
            {
                // The bake will never complete.
                return Err(self.fault(format!("the bake failed: {fault}")));
            }
            if !self.is_over(until, progress) {
                match (until, progress.bake_fault, progress.trace_fault) {
                    (Until::Landed, Some(fault), _) => {
                        return Err(self.fault(format!("the bake failed: {fault}")));
                    }
                    (Until::Traced, _, Some(fault)) => {
                        return Err(self.fault(format!("ray tracing failed: {fault}")));
                    }
                    _ => {}
                }
                match until {
                    Until::Ball if !progress.seeks_ball => {
                        return Err(self.fault("there is no ball to wait for".to_owned()));
                    }
                    Until::Traced if progress.is_playing => {
                        return Err(
                            self.fault("no rays are traced while time runs; pause it first".to_owned())
                        );
                    }
                    _ => {}
                }
                self.check_patience()?;
                return Ok(None);
            }
            self.did();
        }
        Ok(None)
    }

    fn is_over(&self, until: &Until, progress: &Progress<'_>) -> bool {
        match until {
            Until::Loaded => progress.is_loaded,
            Until::Baked => progress.is_loaded && progress.is_baked,
            Until::Landed => progress.has_landed,
            Until::Streamed => progress.is_loaded && progress.is_baked && !progress.is_streaming,
            Until::Traced => progress.is_loaded && progress.is_traced,
            Until::Ball => progress.has_ball,
            Until::Frames(frames) => self.frames >= *frames,
            Until::Size(size) => progress.size == *size,
            Until::Message(text) => progress.messages.iter().any(|m| m.contains(text)),
            Until::Seconds(seconds) => self.since.elapsed().as_secs_f64() >= *seconds,
        }
    }

    /// Checks how long the next step has been waiting.
    ///
    /// # Errors
    /// Returns [`ViewError::ScriptStep`] if it has been too long.
    pub(crate) fn check_patience(&self) -> Result<()> {
        if self.since.elapsed() > TIMEOUT {
            return Err(self.fault(format!("timed out after {} s", TIMEOUT.as_secs())));
        }
        Ok(())
    }

    /// Marks the next step as done.
    pub(crate) fn did(&mut self) {
        self.script.advance();
        self.since = Instant::now();
        self.frames = 0;
    }

    /// Counts a frame that was drawn.
    pub(crate) fn frame(&mut self) {
        self.frames += 1;
    }

    pub(crate) fn waits_for_frames(&self) -> bool {
        matches!(self.script.next(), Some(ScriptStep::Wait { wait: Until::Frames(_) }))
    }

    pub(crate) fn is_done(&self) -> bool {
        self.script.next().is_none()
    }

    /// Returns an error for the next step.
    pub(crate) fn fault(&self, what: String) -> ViewError {
        self.script.fault(what)
    }
}
