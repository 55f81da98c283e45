//! Long work that Python can watch and stop. The work runs on another thread without the interpreter's lock.
//! The calling thread wakes up regularly to report progress to Python, and to check whether Python was
//! interrupted.

use std::any::Any;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use adumbra_bake::{Progress, Watch};
use pyo3::prelude::*;

use crate::errors::Failure;

/// How often the calling thread wakes up.
const TICK: Duration = Duration::from_millis(30);

/// Runs `work` and returns its result. `report` is called with the number of finished root blocks and the
/// total.
///
/// # Errors
/// Returns the error of `work`, or that of `report` or of a signal handler; these two cancel the work.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    report: Option<Py<PyAny>>,
    work: impl FnOnce(Watch<'_>) -> Result<T, Failure> + Send,
) -> PyResult<T> {
    let cancel = AtomicBool::new(false);
    let (done, total) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let progress = |p: Progress| {
        total.store(p.total, Ordering::Relaxed);
        done.fetch_max(p.done, Ordering::Relaxed);
    };
    let mut told = 0;
    let mut look = |py: Python<'_>| {
        py.check_signals()?;
        let so_far = done.load(Ordering::Relaxed);
        if let Some(report) = &report
            && so_far > told
        {
            told = so_far;
            report.call1(py, (so_far, total.load(Ordering::Relaxed)))?;
        }
        Ok(())
    };
    let (result, stopped) = py.detach(|| {
        thread::scope(|scope| {
            let (ends, ended) = channel::<()>();
            let worker = scope.spawn(|| {
                // Dropped at the end, even if the work panics.
                let _ends = ends;
                work(Watch::new(&progress, &cancel))
            });
            let mut stopped: Option<PyErr> = None;
            while ended.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                if stopped.is_none()
                    && let Err(error) = Python::attach(&mut look)
                {
                    cancel.store(true, Ordering::Relaxed);
                    stopped = Some(error);
                }
            }
            (worker.join(), stopped)
        })
    });
    if let Some(error) = stopped {
        return Err(error);
    }
    let made = result.unwrap_or_else(|panic| Err(Failure::Internal(words(&*panic))))?;
    look(py)?;
    Ok(made)
}

/// Returns the message of a panic.
fn words(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "a panic".to_owned())
}
