//! Signals: an interrupt ends the program immediately, at any point, and removes its temporary files. Verbs
//! that have something to finish are asked to stop first. Exceeding a file-size limit becomes an error
//! instead of ending the program.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

#[cfg(unix)]
use signal_hook::consts::SIGHUP;
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::exit::Code;

/// How long the ending program waits for its last message to be written.
#[cfg(unix)]
const PATIENCE: std::time::Duration = std::time::Duration::from_millis(200);

/// The exit code of a program that an interrupt ends.
static CODE: AtomicU8 = AtomicU8::new(Code::Interrupted as u8);

/// Installs the handlers and returns a flag that the first interrupt sets. The second interrupt ends the
/// program. For verbs that look at the flag often.
pub fn install() -> Arc<AtomicBool> {
    let cancel = Arc::new(AtomicBool::new(false));
    listen(&cancel);
    cancel
}

/// Makes the first interrupt end the program with this code. Output files appear whole or not at all, so no
/// verb needs to finish anything.
pub fn end_when_interrupted(code: Code) {
    CODE.store(code as u8, Ordering::Relaxed);
    listen(&Arc::new(AtomicBool::new(true)));
}

/// Starts a thread that handles interrupts, because a signal handler must not remove files. If the flag is
/// already set, an interrupt removes the temporary files and ends the program; otherwise it sets the flag. If
/// signals cannot be received, they keep the system's default action.
#[cfg(unix)]
fn listen(flag: &Arc<AtomicBool>) {
    // Closing the terminal ends the program too, unless it was started by `nohup` or the like.
    let caught = [SIGINT, SIGTERM].into_iter().chain((!ignores_hangup()).then_some(SIGHUP));
    let Ok(mut signals) = signal_hook::iterator::Signals::new(caught) else { return };
    let heard = Arc::clone(flag);
    let each = move || {
        for _ in signals.forever() {
            if heard.swap(true, Ordering::Relaxed) {
                adumbra_files::end_without_temporary_files(end);
            }
        }
    };
    if std::thread::Builder::new().name("signals".to_owned()).spawn(each).is_err() {
        // Without the thread, received signals have no effect until another handler is installed.
        listen_without_thread(flag);
    }
}

#[cfg(unix)]
fn end() -> ! {
    let code = CODE.load(Ordering::Relaxed);
    if code == Code::Interrupted as u8 {
        // Print on a thread: stderr may block if its reader has stopped reading.
        let (said, is_said) = std::sync::mpsc::channel();
        let say = move || {
            crate::note!("error: interrupted; no file was left half written");
            let _ = said.send(());
        };
        if std::thread::Builder::new().spawn(say).is_ok() {
            let _ = is_said.recv_timeout(PATIENCE);
        }
    }
    signal_hook::low_level::exit(code.into())
}

/// Whether the program was started to survive the closing of its terminal. If that is unknown, the system's
/// default action is kept.
#[cfg(unix)]
fn ignores_hangup() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    // Bit 0 is that of signal 1.
    ignored.and_then(|digits| u64::from_str_radix(digits.trim(), 16).ok()).is_none_or(|bits| bits & 1 != 0)
}

#[cfg(not(unix))]
fn listen(flag: &Arc<AtomicBool>) {
    listen_without_thread(flag);
}

/// Makes an interrupt end the program if the flag is already set, and set the flag otherwise. Temporary files
/// remain.
fn listen_without_thread(flag: &Arc<AtomicBool>) {
    for signal in [SIGINT, SIGTERM] {
        // If a handler cannot be set, the signal keeps its present action.
        let _ = signal_hook::flag::register_conditional_shutdown(
            signal,
            Code::Interrupted as i32,
            Arc::clone(flag),
        );
        let _ = signal_hook::flag::register(signal, Arc::clone(flag));
    }
}

/// Turns writing past a file-size limit into an error (EFBIG). Without a handler the signal would end the
/// program.
pub(crate) fn survive_file_size_limit() {
    #[cfg(unix)]
    {
        // If the handler cannot be set, the system's default action remains.
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)));
    }
}
