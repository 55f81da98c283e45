//! Ctrl-C asks the work to stop, a second one ends the program; a file-size limit becomes an error, not a death.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
#[cfg(unix)]
use std::sync::atomic::Ordering;

use signal_hook::consts::{SIGINT, SIGTERM};

use crate::exit::Code;

/// A flag that the first interrupt sets; the second ends the program.
pub(crate) fn install() -> Arc<AtomicBool> {
    let cancel = Arc::new(AtomicBool::new(false));
    listen(Arc::clone(&cancel));
    cancel
}

/// Ends the program at the first interrupt, for verbs that have nothing to finish.
pub(crate) fn end_when_interrupted() {
    listen(Arc::new(AtomicBool::new(true)));
}

/// At an interrupt ends the program where the flag is set, without its temporary files; else sets it. A thread does it: a handler may not
/// remove files. Where that cannot be had, the signal ends the program as the system has it.
#[cfg(unix)]
fn listen(flag: Arc<AtomicBool>) {
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) else { return };
    let each = move || {
        for _ in signals.forever() {
            if flag.swap(true, Ordering::Relaxed) {
                adumbra::files::end_without_temporary_files(end);
            }
        }
    };
    // Where no thread can be had, the signals are closed with what was to hold them.
    let _ = std::thread::Builder::new().name("signals".to_owned()).spawn(each);
}

#[cfg(unix)]
fn end() -> ! {
    signal_hook::low_level::exit(Code::Interrupted as i32)
}

/// At an interrupt ends the program where the flag is set, else sets it.
#[cfg(not(unix))]
fn listen(flag: Arc<AtomicBool>) {
    for signal in [SIGINT, SIGTERM] {
        // Where a handler cannot be set, the signal ends the program as the system has it.
        let _ = signal_hook::flag::register_conditional_shutdown(
            signal,
            Code::Interrupted as i32,
            Arc::clone(&flag),
        );
        let _ = signal_hook::flag::register(signal, Arc::clone(&flag));
    }
}

/// Makes writing past a limit on file sizes an error (EFBIG); without any handler it would end the program.
pub(crate) fn survive_file_size_limit() {
    #[cfg(unix)]
    {
        // Where it cannot be set, the system's own way stays.
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)));
    }
}
