//! Ctrl-C asks the work to stop, a second one ends the program; a file-size limit becomes an error, not a death.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::exit::Code;

/// A flag that the first interrupt sets.
pub(crate) fn install() -> Arc<AtomicBool> {
    let cancel = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // Where a handler cannot be set, the signal ends the program as the system has it.
        let _ = flag::register_conditional_shutdown(signal, Code::Interrupted as i32, Arc::clone(&cancel));
        let _ = flag::register(signal, Arc::clone(&cancel));
    }
    cancel
}

/// Ends the program at the first interrupt, for verbs that have nothing to finish.
pub(crate) fn end_when_interrupted() {
    let at_once = Arc::new(AtomicBool::new(true));
    for signal in [SIGINT, SIGTERM] {
        // Where a handler cannot be set, the signal ends the program as the system has it.
        let _ = flag::register_conditional_shutdown(signal, Code::Interrupted as i32, Arc::clone(&at_once));
    }
}

/// Makes writing past a limit on file sizes an error (EFBIG); without any handler it would end the program.
pub(crate) fn survive_file_size_limit() {
    #[cfg(unix)]
    {
        // Where it cannot be set, the system's own way stays.
        let _ = flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)));
    }
}
