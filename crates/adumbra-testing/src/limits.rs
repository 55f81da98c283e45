//! Runs at the least `--max-memory` that works, and at twice as much.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

const MIB: u64 = 1 << 20;
/// What the program holds while it refuses the smallest of limits.
const PROGRAM_BYTES: u64 = 24 * MIB;

/// The end of a run.
struct Ended {
    code: i32,
    peak_bytes: u64,
    stderr: String,
}

impl Ended {
    /// Whether the work was done. A comparison may find that a coarse file misses a promise.
    fn is_done(&self) -> bool {
        matches!(self.code, 0 | 1)
    }
}

/// The peak of what a process holds besides pages of its own program file, while it runs. How many of those the system maps
/// ahead depends on what else runs, and it takes them back at any time.
fn peak_bytes(child: &Child) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).ok()?;
    let kib = |name: &str| {
        let line = status.lines().find(|line| line.starts_with(name))?;
        line.split_whitespace().nth(1)?.parse::<u64>().ok()
    };
    Some(kib("VmHWM:")?.saturating_sub(kib("RssFile:")?) * 1024)
}

/// Runs a program and watches its peak.
fn run(program: &Path, arguments: &[&str], limit_bytes: u64) -> Ended {
    let limit = limit_bytes.to_string();
    let mut child = Command::new(program)
        .args(arguments)
        .args(["--threads", "2", "--max-memory", &limit])
        // The program starts itself again without it.
        .env("XDG_RUNTIME_DIR", "/nonexistent")
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut peak = 0;
    let status = loop {
        peak = peak_bytes(&child).unwrap_or(0).max(peak);
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        std::thread::sleep(Duration::from_micros(500));
    };
    let stderr = std::io::read_to_string(child.stderr.take().unwrap()).unwrap();
    Ended { code: status.code().unwrap(), peak_bytes: peak, stderr }
}

/// The number of MiB that a refusal says are needed.
fn needed_bytes(stderr: &str) -> u64 {
    let words: Vec<&str> = stderr.split_whitespace().collect();
    let at = words.windows(2).position(|w| w[0] != "but" && w[1].starts_with("MiB")).unwrap();
    words[at].parse::<u64>().unwrap_or_else(|_| panic!("{stderr}")) * MIB
}

/// Runs a program at the limits that its refusals ask for, from 1 MiB on, until it is done. Calls `refused` with each limit that
/// it refuses. Returns the least limit that works.
fn follow_refusals(program: &Path, arguments: &[&str], refused: impl Fn(u64, &Ended)) -> (u64, Ended) {
    let mut limit = MIB;
    let mut refusals = 0;
    let ended = loop {
        let ended = run(program, arguments, limit);
        if ended.is_done() {
            break ended;
        }
        assert_eq!(ended.code, 4, "{arguments:?} at {limit}: {}", ended.stderr);
        assert!(ended.stderr.contains("--max-memory"), "{}", ended.stderr);
        refused(limit, &ended);
        let needed = needed_bytes(&ended.stderr);
        assert!(needed > limit, "{arguments:?} at {limit}: {}", ended.stderr);
        limit = needed;
        refusals += 1;
        assert!(refusals < 60, "{arguments:?}: {}", ended.stderr);
    };
    assert!(refusals > 0, "{arguments:?}");
    (limit, ended)
}

/// Runs a program until it has the memory that its refusals ask for. The last of the runs does its work.
///
/// # Panics
///
/// Panics if a run fails otherwise, or if a refusal asks for no more than there was.
pub fn run_with_the_memory_it_asks_for(program: &Path, arguments: &[&str]) {
    follow_refusals(program, arguments, |_, _| ());
}

/// Runs a program at the least limit that works, found from what refusals say, and at twice as much. Only on Linux, where
/// the peak can be watched.
///
/// # Panics
///
/// Panics if a run takes more than its limit, before it refuses it or until it ends.
pub fn assert_keeps_to_limits(program: &Path, arguments: &[&str]) {
    let (limit, ended) = follow_refusals(program, arguments, |limit, ended| {
        let most = (limit + limit / 20).max(PROGRAM_BYTES);
        assert!(
            ended.peak_bytes <= most,
            "{arguments:?} takes {} MiB before it refuses {} MiB: {}",
            ended.peak_bytes / MIB,
            limit / MIB,
            ended.stderr
        );
    });
    for (limit, ended) in [(limit, ended), (2 * limit, run(program, arguments, 2 * limit))] {
        assert!(ended.is_done(), "{arguments:?} at {limit}: {}", ended.stderr);
        assert!(
            ended.peak_bytes <= limit + limit / 20,
            "{arguments:?} takes {:.1} MiB of {:.1}",
            ended.peak_bytes as f64 / MIB as f64,
            limit as f64 / MIB as f64
        );
    }
}
