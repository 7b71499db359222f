//! Threads for work without the GIL. A child of `os.fork` does not have its parent's threads and gets its own.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::errors::value;

/// Threads, and the process that they belong to.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Interval of the checks for signals.
const SIGNALS: Duration = Duration::from_millis(50);

/// Runs work on the threads of this process, without the GIL.
pub(crate) fn install<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = pool()?;
    Ok(py.detach(|| pool.install(work)))
}

/// The same, until Ctrl-C, which Python reports only in the thread of the caller.
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
    let pool = pool()?;
    py.detach(|| {
        pool.in_place_scope(|scope| {
            let (done, result) = mpsc::channel();
            scope.spawn(move |_| {
                // The receiver is gone after a signal.
                let _ = done.send(work());
            });
            loop {
                match result.recv_timeout(SIGNALS) {
                    Ok(result) => return Ok(result),
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(value("the work has failed"));
                    }
                    Err(RecvTimeoutError::Timeout) => {
                        signals().inspect_err(|_| stop.store(true, Ordering::Relaxed))?;
                    }
                }
            }
        })
    })
}

fn signals() -> PyResult<()> {
    Python::attach(|py| {
        py.check_signals()?;
        Ok(())
    })
}

/// Called with the GIL, like `os.fork`, so a child never inherits a held lock.
fn pool() -> PyResult<Arc<ThreadPool>> {
    let mut held = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let own = process::id();
    if let Some((_, pool)) = held.as_ref().filter(|(process, _)| *process == own) {
        return Ok(Arc::clone(pool));
    }
    let pool = Arc::new(ThreadPoolBuilder::new().build().map_err(value)?);
    // Dropping the parent's pool would wait for threads that this process does not have.
    std::mem::forget(held.replace((own, Arc::clone(&pool))));
    Ok(pool)
}
