//! A command with all that it starts itself: benchmarks bake in processes of their own, which must not outlive a report.

use std::io::Result;
use std::process::{Child, ChildStderr, Command, ExitStatus};

/// On Unix a process group of its own, which a terminal's interrupt does not reach: who waits passes it on. Elsewhere the command alone.
pub(super) struct Group {
    leader: Child,
}

impl Group {
    pub(super) fn spawn(command: &mut Command) -> Result<Self> {
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        Ok(Self { leader: command.spawn()? })
    }

    /// Its pipe, once, where it was asked for.
    pub(super) fn stderr(&mut self) -> Option<ChildStderr> {
        self.leader.stderr.take()
    }

    /// How the command ended, if it has.
    pub(super) fn status(&mut self) -> Result<Option<ExitStatus>> {
        self.leader.try_wait()
    }

    /// Asks all of it to end, where the system has a way to ask.
    pub(super) fn ask(&self) {
        #[cfg(unix)]
        self.signal(rustix::process::Signal::TERM);
    }

    /// Ends what is left of it.
    pub(super) fn kill(&mut self) {
        #[cfg(unix)]
        self.signal(rustix::process::Signal::KILL);
        // Where it is gone already there is nothing to end.
        #[cfg(not(unix))]
        let _ = self.leader.kill();
    }

    #[cfg(unix)]
    fn signal(&self, signal: rustix::process::Signal) {
        if let Some(group) = rustix::process::Pid::from_raw(self.leader.id().cast_signed()) {
            // A group that is gone has ended as it should.
            let _ = rustix::process::kill_process_group(group, signal);
        }
    }
}
