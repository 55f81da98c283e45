//! One command of a report, run by this program in a process of its own: what it holds goes with it, and if it dies the report lives.

use std::collections::VecDeque;
use std::io::{BufRead as _, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use adumbra::Error;

use super::group::Group;
use super::record::{Outcome, StepRecord};
use crate::exit::{Code, Failure};

/// Where words of commands lead.
pub(super) struct Places {
    /// Where commands are run.
    pub(super) folder: PathBuf,
    /// Name in commands, and the folder that it stands for.
    pub(super) variables: Vec<(&'static str, PathBuf)>,
}

/// A command to run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Step {
    /// What the page calls it.
    pub(super) name: String,
    /// Words behind the program's name.
    pub(super) words: Vec<String>,
}

/// How long an interrupted command may take to end by itself, and what a command started may outlive it.
const GRACE: Duration = Duration::from_secs(2);
const POLL: Duration = Duration::from_millis(20);
/// Lines of what a command said that are kept.
const KEPT_LINES: usize = 8;

/// Reads what a command says; gives the last lines.
type Said = JoinHandle<VecDeque<String>>;

impl Step {
    /// A step from words with blanks between.
    pub(super) fn new(name: &str, words: &str) -> Self {
        Self { name: name.to_owned(), words: words.split_whitespace().map(str::to_owned).collect() }
    }

    /// As one types it in the report's folder.
    pub(super) fn command(&self) -> String {
        format!("adumbra {}", self.words.join(" "))
    }

    /// Runs it; its words on stderr go through, those on stdout are dropped.
    pub(super) fn run(&self, places: &Places, cancel: &AtomicBool) -> Result<(StepRecord, Outcome), Failure> {
        let start = Instant::now();
        let program = std::env::current_exe().map_err(Error::io("find", "this program"))?;
        let mut command = Command::new(&program);
        command.args(self.words.iter().map(|w| places.expand(w))).current_dir(&places.folder);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut group = Group::spawn(&mut command).map_err(Error::io("run", &program))?;
        let said = group.stderr().map(|stderr| std::thread::spawn(move || pass_on(stderr)));
        let status = wait(&mut group, said.as_ref(), cancel).map_err(Error::io("wait for", &program))?;
        // What still holds the pipe is out of reach; it may talk on, and nobody waits for it.
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

/// Prints lines as they come; gives the last ones.
fn pass_on(stderr: impl Read) -> VecDeque<String> {
    let mut kept = VecDeque::new();
    for line in BufReader::new(stderr).lines().map_while(Result::ok) {
        eprintln!("  {line}");
        if kept.len() == KEPT_LINES {
            kept.pop_front();
        }
        kept.push_back(line);
    }
    kept
}

/// Waits until the command has ended and all that it started has closed the pipe. Interrupted it is asked to end; what is left of it
/// [`GRACE`] later, or so long after the command itself, is killed.
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

/// Why it ended so: its own last error, or else how it ended.
fn cause(said: &VecDeque<String>, status: ExitStatus) -> String {
    let told = |l: &&String| l.starts_with("error: ") || l.starts_with("check failed: ");
    match said.iter().rev().find(told).or(said.back()) {
        Some(line) => line.strip_prefix("error: ").unwrap_or(line).to_owned(),
        None => status.to_string(),
    }
}
