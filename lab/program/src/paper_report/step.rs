//! One command of a report, run in a separate process.
//!
//! Its memory is freed when it ends, and the report survives if it crashes.

use adumbra::IoError;
use std::collections::VecDeque;
use std::io::{BufRead as _, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use adumbra_program::exit::Code;

use super::group::Group;
use super::record::{Outcome, StepRecord};
use crate::programs::Program;
use adumbra_compare::Result;

/// The folders that commands refer to.
pub(super) struct Places {
    /// Folder in which commands are run.
    pub(super) folder: PathBuf,
    /// Variable names in commands, each with the folder that replaces it.
    pub(super) variables: Vec<(&'static str, PathBuf)>,
}

/// A command to run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CommandStep {
    /// Name on the page.
    pub(super) name: String,
    program: Program,
    /// Arguments of the program.
    pub(super) words: Vec<String>,
}

/// Time that an interrupted command has to end by itself, and that child processes may outlive their command.
const GRACE: Duration = Duration::from_secs(2);
const POLL: Duration = Duration::from_millis(20);
/// Number of lines kept of a command's output.
const KEPT_LINES: usize = 8;

/// Thread that reads a command's output and returns the last lines.
type Said = JoinHandle<VecDeque<String>>;

impl CommandStep {
    /// Creates a command of `adumbra` from arguments separated by blanks.
    pub(super) fn product(name: &str, words: &str) -> Self {
        Self::new(name, Program::Product, words)
    }

    /// Creates a command of this program from arguments separated by blanks.
    pub(super) fn laboratory(name: &str, words: &str) -> Self {
        Self::new(name, Program::Laboratory, words)
    }

    fn new(name: &str, program: Program, words: &str) -> Self {
        Self { name: name.to_owned(), program, words: words.split_whitespace().map(str::to_owned).collect() }
    }

    /// Returns the command line to type in the report's folder.
    pub(super) fn command(&self) -> String {
        format!("{} {}", self.program.name(), self.words.join(" "))
    }

    /// Runs the command. Its stderr is passed on, its stdout discarded.
    pub(super) fn run(&self, places: &Places, cancel: &AtomicBool) -> Result<(StepRecord, Outcome)> {
        let start = Instant::now();
        let program = self.program.path()?;
        let mut command = Command::new(&program);
        command.args(self.words.iter().map(|w| places.expand(w))).current_dir(&places.folder);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut group = Group::spawn(&mut command).map_err(IoError::at("run", &program))?;
        let said = group.stderr().map(|stderr| std::thread::spawn(move || pass_on(stderr)));
        let status = wait(&mut group, said.as_ref(), cancel).map_err(IoError::at("wait for", &program))?;
        // A process that still holds the pipe cannot be killed. Do not wait for it.
        let said = said.filter(JoinHandle::is_finished).and_then(|s| s.join().ok()).unwrap_or_default();
        let outcome = if cancel.load(Ordering::Relaxed) {
            Outcome::Interrupted
        } else if status.success() {
            Outcome::Measured
        } else if status.code() == Some(Code::CheckFailed as i32) {
            Outcome::CheckFailed
        } else {
            Outcome::Failed
        };
        let error = (outcome != Outcome::Measured).then(|| cause(&said, status));
        let record = StepRecord {
            name: self.name.clone(),
            command: self.command(),
            seconds: start.elapsed().as_secs_f64(),
            error,
        };
        Ok((record, outcome))
    }
}

impl Places {
    fn expand(&self, word: &str) -> PathBuf {
        for (name, folder) in &self.variables {
            if let Some(rest) = word.strip_prefix(name) {
                return folder.join(rest.trim_start_matches('/'));
            }
        }
        Path::new(word).to_owned()
    }
}

/// Prints lines as they arrive and returns the last ones.
fn pass_on(stderr: impl Read) -> VecDeque<String> {
    let mut kept = VecDeque::new();
    for line in BufReader::new(stderr).lines().map_while(Result::ok) {
        adumbra_program::note!("  {line}");
        if kept.len() == KEPT_LINES {
            kept.pop_front();
        }
        kept.push_back(line);
    }
    kept
}

/// Waits until the command has ended and all processes that it started have closed the pipe.
///
/// If interrupted, the group is asked to end. Processes of the group that still run [`GRACE`] after that, or
/// after the command itself has ended, are killed.
fn wait(group: &mut Group, said: Option<&Said>, cancel: &AtomicBool) -> std::io::Result<ExitStatus> {
    let mut asked = false;
    let mut status = None;
    let mut ending: Option<Instant> = None;
    loop {
        if status.is_none() {
            status = group.status()?;
        }
        if let Some(status) = status
            && said.is_none_or(JoinHandle::is_finished)
        {
            return Ok(status);
        }
        if !asked && cancel.load(Ordering::Relaxed) {
            asked = true;
            group.ask();
        }
        if asked || status.is_some() {
            let since = ending.get_or_insert_with(Instant::now).elapsed();
            if since > GRACE {
                group.kill();
            }
            if let Some(status) = status
                && since > 2 * GRACE
            {
                return Ok(status);
            }
        }
        std::thread::sleep(POLL);
    }
}

/// Returns why a command failed: its last error message, else its last line, else its exit status.
fn cause(said: &VecDeque<String>, status: ExitStatus) -> String {
    let is_reason = |l: &&String| l.starts_with("error: ") || l.starts_with("check failed: ");
    match said.iter().rev().find(is_reason).or(said.back()) {
        Some(line) => line.strip_prefix("error: ").unwrap_or(line).to_owned(),
        None => status.to_string(),
    }
}
