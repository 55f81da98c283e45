//! Plays a script: gives its commands when what comes before them is done.

use std::collections::VecDeque;
use std::time::Instant;

use crate::command::Command;
use crate::error::{Result, ViewError};
use crate::script::{PATIENCE, Script, Step, Until};

/// Where the view stands, as far as scripts wait for it.
pub(crate) struct Progress<'a> {
    pub(crate) is_loaded: bool,
    pub(crate) is_baked: bool,
    pub(crate) has_landed: bool,
    pub(crate) is_traced: bool,
    pub(crate) is_playing: bool,
    pub(crate) has_ball: bool,
    pub(crate) seeks_ball: bool,
    pub(crate) size: [u32; 2],
    /// Why a bake failed that is waited for.
    pub(crate) bake_fault: Option<&'a str>,
    /// Why rays failed that are waited for.
    pub(crate) trace_fault: Option<&'a str>,
    /// What was said.
    pub(crate) messages: &'a VecDeque<String>,
}

pub(crate) struct Player {
    script: Script,
    /// When the step that is next was reached.
    since: Instant,
    /// Frames drawn since.
    frames: u32,
}

impl Player {
    pub(crate) fn new(script: Script) -> Self {
        Self { script, since: Instant::now(), frames: 0 }
    }

    /// The command to do now; none where one is to be waited for, or none is left.
    ///
    /// # Errors
    /// [`ViewError::Step`] for what was waited for too long.
    pub(crate) fn next(&mut self, progress: &Progress<'_>) -> Result<Option<Command>> {
        while let Some(step) = self.script.next() {
            let until = match step {
                Step::Do(command) => return Ok(Some(command.clone())),
                Step::Wait { wait } => wait,
            };
            if *until == Until::Baked
                && let Some(fault) = progress.bake_fault
            {
                // It is settled that there will be none.
                return Err(self.fault(format!("the bake failed: {fault}")));
            }
            if !self.is_over(until, progress) {
                match (until, progress.bake_fault, progress.trace_fault) {
                    (Until::Landed, Some(fault), _) => {
                        return Err(self.fault(format!("the bake failed: {fault}")));
                    }
                    (Until::Traced, _, Some(fault)) => return Err(self.fault(format!("rays: {fault}"))),
                    _ => {}
                }
                match until {
                    Until::Ball if !progress.seeks_ball => {
                        return Err(self.fault("there is no ball, and none is looked for".to_owned()));
                    }
                    Until::Traced if progress.is_playing => {
                        return Err(self.fault("no rays are traced while time goes on".to_owned()));
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
            Until::Traced => progress.is_loaded && progress.is_traced,
            Until::Ball => progress.has_ball,
            Until::Frames(frames) => self.frames >= *frames,
            Until::Size(size) => progress.size == *size,
            Until::Message(text) => progress.messages.iter().any(|m| m.contains(text)),
            Until::Seconds(seconds) => self.since.elapsed().as_secs_f64() >= *seconds,
        }
    }

    /// Whether the step that is next has been waited for too long.
    ///
    /// # Errors
    /// [`ViewError::Step`] where it has.
    pub(crate) fn check_patience(&self) -> Result<()> {
        if self.since.elapsed() > PATIENCE {
            return Err(self.fault(format!("waited for {} s", PATIENCE.as_secs())));
        }
        Ok(())
    }

    /// The step is done.
    pub(crate) fn did(&mut self) {
        self.script.advance();
        self.since = Instant::now();
        self.frames = 0;
    }

    /// A frame was drawn.
    pub(crate) fn frame(&mut self) {
        self.frames += 1;
    }

    pub(crate) fn waits_for_frames(&self) -> bool {
        matches!(self.script.next(), Some(Step::Wait { wait: Until::Frames(_) }))
    }

    pub(crate) fn is_done(&self) -> bool {
        self.script.next().is_none()
    }

    /// An error of the step that is next.
    pub(crate) fn fault(&self, what: String) -> ViewError {
        self.script.fault(what)
    }
}
