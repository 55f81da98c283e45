//! The view's script: its next steps, the conditions they wait for, and how it ends.

use super::{App, BallState};
use crate::command::Command;
use crate::error::{Result, ViewError};
use crate::player::{Player, Progress};

impl App {
    /// Plays the script as far as it can proceed now.
    pub(super) fn play(&mut self) -> Result<()> {
        let Some(mut player) = self.player.take() else { return Ok(()) };
        loop {
            if self.window_shot.is_some() {
                // The picture is written with the next frame.
                player.check_patience()?;
                break;
            }
            if let Some(done) = self.window_shot_done.take() {
                done.map_err(|what| player.fault(what))?;
                player.did();
                continue;
            }
            match player.next(&self.progress())? {
                None => break,
                Some(command) => {
                    match self.try_command(&command) {
                        // The window shows or refuses a dropped file, even if a script dropped it.
                        Err(what) if matches!(command, Command::Drop(_)) => self.messages.error(what),
                        Err(what) => return Err(player.fault(what)),
                        Ok(()) => {}
                    }
                    match command {
                        Command::WindowShot(_) => continue,
                        Command::Screenshot(_) => self.check_shot(&player)?,
                        _ => {}
                    }
                    player.did();
                    if self.quit {
                        return Ok(());
                    }
                }
            }
        }
        // A step that waits for frames causes them to be drawn.
        self.dirty |= player.waits_for_frames() || self.window_shot.is_some();
        self.player = (!player.is_done()).then_some(player);
        Ok(())
    }

    /// Returns an error if a visible technique cannot be drawn, because the screenshot would not show it.
    fn check_shot(&self, player: &Player) -> Result<()> {
        let failure = self.stage.as_ref().and_then(|stage| stage.failure(&self.settings));
        failure.map_or(Ok(()), |what| Err(player.fault(what.to_owned())))
    }

    /// Returns an error if the view ends now although the script is unfinished.
    pub(crate) fn unfinished(&self) -> Option<ViewError> {
        self.player.as_ref().map(|player| player.fault("the window was closed".to_owned()))
    }

    fn progress(&self) -> Progress<'_> {
        let stage = self.stage.as_ref();
        let key = stage.and_then(|s| s.trace_key(&self.settings));
        Progress {
            is_loaded: stage.is_some() && self.loads.are_done() && self.reading == 0,
            is_baked: match &self.day {
                Some(day) => !day.is_busy(),
                None => stage.is_some_and(|s| self.shadows.is_settled(&self.settings, s.scene())),
            },
            is_streaming: self.shadows.is_streaming(&self.settings),
            has_landed: stage.is_some() && self.shadows.has_landed(&self.settings),
            is_playing: self.settings.playing,
            seeks_ball: stage.is_none() || self.ball == BallState::Sought,
            is_traced: stage.is_some_and(|s| key.as_ref().is_none_or(|k| s.has_traced(k))),
            has_ball: stage.is_some_and(|s| s.ball().is_some()),
            size: [self.settings.camera.width, self.settings.camera.height],
            bake_fault: stage.and_then(|s| self.shadows.fault(&self.settings, s.scene())),
            trace_fault: self.trace_fault.as_deref(),
            messages: self.messages.said(),
        }
    }
}
