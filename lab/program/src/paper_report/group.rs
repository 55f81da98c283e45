//! A command with all processes that it starts.
//!
//! Benchmarks bake in child processes, which must not outlive a report.

use std::io::Result;
use std::process::{Child, ChildStderr, Command, ExitStatus};

/// A command and its child processes, in a separate process group on Unix; elsewhere, the command alone.
///
/// A terminal's interrupt does not reach the group, so the code that waits for the group must forward the
/// interrupt.
pub(super) struct Group {
    leader: Child,
}

impl Group {
    pub(super) fn spawn(command: &mut Command) -> Result<Self> {
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        Ok(Self { leader: command.spawn()? })
    }

    /// Takes the pipe of its stderr. Returns `None` if it is not piped or already taken.
    pub(super) fn stderr(&mut self) -> Option<ChildStderr> {
        self.leader.stderr.take()
    }

    /// Returns the command's exit status, if it has ended.
    pub(super) fn status(&mut self) -> Result<Option<ExitStatus>> {
        self.leader.try_wait()
    }

    /// Requests that the whole group terminate, on systems that support it.
    pub(super) fn ask(&self) {
        #[cfg(unix)]
        self.signal(rustix::process::Signal::TERM);
    }

    /// Kills all remaining processes of the group.
    pub(super) fn kill(&mut self) {
        #[cfg(unix)]
        self.signal(rustix::process::Signal::KILL);
        // If it has ended already, there is nothing to kill.
        #[cfg(not(unix))]
        let _ = self.leader.kill();
    }

    #[cfg(unix)]
    fn signal(&self, signal: rustix::process::Signal) {
        if let Some(group) = rustix::process::Pid::from_raw(self.leader.id().cast_signed()) {
            // A group that no longer exists has ended as intended.
            let _ = rustix::process::kill_process_group(group, signal);
        }
    }
}
