//! Time limits of commands, including everything that they start.

use std::fs::File;
use std::io::{self, Read as _, Seek as _};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

const POLL: Duration = Duration::from_millis(10);

/// Whether this program was interrupted. A terminal does not signal the commands that the program runs,
/// because each is in a separate process group.
pub(crate) struct Interrupt(Arc<AtomicBool>);

/// The time until which commands may run.
pub(crate) struct Limit {
    start: Instant,
    most: Duration,
    interrupt: Arc<AtomicBool>,
}

impl Interrupt {
    pub(crate) fn install() -> io::Result<Self> {
        let asked = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            flag::register(signal, Arc::clone(&asked))?;
        }
        Ok(Self(asked))
    }

    /// Returns an error if this program was interrupted.
    pub(crate) fn check(&self) -> io::Result<()> {
        if self.0.load(Ordering::Relaxed) { Err(interrupted()) } else { Ok(()) }
    }

    /// Returns a limit that starts now and applies to all commands together.
    pub(crate) fn after(&self, most: Duration) -> Limit {
        Limit { start: Instant::now(), most, interrupt: Arc::clone(&self.0) }
    }
}

impl Limit {
    /// Runs a command without input. If it is not done in time, kills it with everything that it started and
    /// returns an error.
    pub(crate) fn output(&self, command: &mut Command) -> io::Result<Output> {
        // Use files instead of pipes: a file needs no reader while the command runs, and no wait for other
        // processes that hold it open.
        let [mut stdout, mut stderr] = [tempfile::tempfile()?, tempfile::tempfile()?];
        command.stdin(Stdio::null()).stdout(stdout.try_clone()?).stderr(stderr.try_clone()?);
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        let mut child = command.spawn()?;
        let status = self.wait(&mut child);
        if status.is_err() {
            kill(&mut child)?;
        }
        Ok(Output { status: status?, stdout: content(&mut stdout)?, stderr: content(&mut stderr)? })
    }

    fn wait(&self, child: &mut Child) -> io::Result<ExitStatus> {
        loop {
            if let Some(status) = child.try_wait()? {
                return Ok(status);
            }
            if self.interrupt.load(Ordering::Relaxed) {
                return Err(interrupted());
            }
            if self.start.elapsed() > self.most {
                let minutes = self.most.as_secs_f64() / 60.0;
                return Err(io::Error::new(
                    io::ErrorKind::TimedOut,
                    format!("killed after {minutes:.0} minutes"),
                ));
            }
            thread::sleep(POLL);
        }
    }
}

fn interrupted() -> io::Error {
    io::Error::new(io::ErrorKind::Interrupted, "interrupted")
}

/// Kills a command and, if the system has process groups, everything that it started.
fn kill(child: &mut Child) -> io::Result<()> {
    #[cfg(unix)]
    if let Some(group) = rustix::process::Pid::from_raw(child.id().cast_signed()) {
        // A group that no longer exists has already ended.
        let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
    }
    child.kill()?;
    child.wait().map(|_| ())
}

fn content(file: &mut File) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.rewind()?;
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limit(most: Duration) -> Limit {
        Interrupt(Arc::default()).after(most)
    }

    #[cfg(unix)]
    fn shell(line: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", line]);
        command
    }

    #[cfg(unix)]
    #[test]
    fn limit_returns_output_and_exit_code() {
        let output = limit(Duration::from_secs(60)).output(&mut shell("echo a; echo b >&2; exit 3")).unwrap();
        assert_eq!(
            (output.status.code(), output.stdout, output.stderr),
            (Some(3), b"a\n".into(), b"b\n".into())
        );
    }

    #[cfg(unix)]
    #[test]
    fn limit_kills_command_and_its_children() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("late");
        let line = format!("(sleep 2; echo late > '{}') & wait", file.display());
        let start = Instant::now();
        let error = limit(Duration::from_millis(200)).output(&mut shell(&line)).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
        thread::sleep(Duration::from_secs(3).saturating_sub(start.elapsed()));
        assert!(!file.exists(), "what it started lives on");
    }

    #[cfg(unix)]
    #[test]
    fn limit_ends_command_on_interrupt() {
        let interrupt = Interrupt(Arc::new(AtomicBool::new(true)));
        let error = interrupt.after(Duration::from_secs(600)).output(&mut shell("sleep 600")).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::Interrupted);
        assert!(interrupt.check().is_err());
    }
}
