//! Threads for work without the GIL. They end with the call, so a child of `os.fork` never waits for threads that it
//! lacks.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;
use rayon::ThreadPoolBuilder;

use crate::errors::value;

/// Interval of the checks for signals.
const SIGNALS: Duration = Duration::from_millis(20);

/// Runs work on all processors, without the GIL.
pub(crate) fn install<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = ThreadPoolBuilder::new().build().map_err(value)?;
    Ok(py.detach(|| pool.install(work)))
}

/// As [`install`], until Ctrl-C. Python reports Ctrl-C only in the thread of the caller.
///
/// * `stop`: set by Ctrl-C; the work ends soon after.
///
/// # Errors
/// `KeyboardInterrupt`, or another exception of a signal handler.
pub(crate) fn install_until<T: Send>(
    py: Python<'_>,
    stop: &AtomicBool,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    let pool = ThreadPoolBuilder::new().build().map_err(value)?;
    py.detach(|| {
        thread::scope(|scope| {
            let working = scope.spawn(|| pool.install(work));
            while !working.is_finished() {
                thread::sleep(SIGNALS);
                let stopped = |_: &PyErr| stop.store(true, Ordering::Relaxed);
                Python::attach(|py| py.check_signals().inspect_err(stopped))?;
            }
            working.join().map_err(|_| value("the work has failed"))
        })
    })
}
