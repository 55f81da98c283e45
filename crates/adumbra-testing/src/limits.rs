//! Runs a program at the lowest `--max-memory` that works, and at twice that limit.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

const MIB: u64 = 1 << 20;
/// Memory that the program uses while it rejects the lowest limits, bytes.
const PROGRAM_BYTES: u64 = 24 * MIB;

/// The result of a run.
struct Ended {
    code: i32,
    peak_bytes: u64,
    stderr: String,
}

impl Ended {
    /// Whether the program did its work. Exit code 1 counts too: a comparison may find that a coarse file
    /// breaks a promise.
    fn is_done(&self) -> bool {
        matches!(self.code, 0 | 1)
    }
}

/// The peak memory of a running process, excluding pages of its program file. The system maps those pages
/// ahead depending on what else runs, and may reclaim them at any time.
fn peak_bytes(child: &Child) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).ok()?;
    let kib = |name: &str| {
        let line = status.lines().find(|line| line.starts_with(name))?;
        line.split_whitespace().nth(1)?.parse::<u64>().ok()
    };
    Some(kib("VmHWM:")?.saturating_sub(kib("RssFile:")?) * 1024)
}

/// Runs a program and tracks its peak memory.
fn run(program: &Path, arguments: &[&str], limit_bytes: u64) -> Ended {
    let limit = limit_bytes.to_string();
    let mut child = Command::new(program)
        .args(arguments)
        .args(["--threads", "2", "--max-memory", &limit])
        // Without this variable, the program would execute itself again.
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

/// The memory that a rejection asks for, bytes.
fn needed_bytes(stderr: &str) -> u64 {
    let words: Vec<&str> = stderr.split_whitespace().collect();
    let at = words.windows(2).position(|w| w[0] != "but" && w[1].starts_with("MiB")).unwrap();
    words[at].parse::<u64>().unwrap_or_else(|_| panic!("{stderr}")) * MIB
}

/// Runs a program repeatedly, from 1 MiB on, each time with the limit that the previous rejection asked for,
/// until the run succeeds. Calls `refused` with each rejected limit. Returns the lowest limit that works.
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

/// Runs a program repeatedly, with the memory that its rejections ask for, until a run succeeds.
///
/// # Panics
///
/// Panics if a run fails for another reason, or if a rejection asks for no more memory than the run had.
pub fn run_with_the_memory_it_asks_for(program: &Path, arguments: &[&str]) {
    follow_refusals(program, arguments, |_, _| ());
}

/// Runs a program at the lowest limit that works, found by following its rejections, and at twice that limit.
/// Only on Linux, where the peak can be measured.
///
/// # Panics
///
/// Panics if a run uses more memory than its limit, whether it then rejects the limit or succeeds.
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
