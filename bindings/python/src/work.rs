//! Work in Rust while Python goes on: without its lock, with its signals, never in a forked process.

use crate::error;
use eyot::Cancel;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

/// Python is asked this often whether somebody pressed Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// No machine has more cores, and each thread takes memory.
const MOST_THREADS: usize = 1024;

/// The process that imported the package.
static PROCESS: OnceLock<u32> = OnceLock::new();

/// Remembers the process.
pub(crate) fn begin() {
    PROCESS.get_or_init(std::process::id);
}

/// Threads of a number that was asked for; 0 for as many as there are cores. Those of the last number are kept for the next run.
pub(crate) fn pool(py: Python<'_>, threads: usize) -> PyResult<Arc<ThreadPool>> {
    static LAST: Mutex<Option<(usize, Arc<ThreadPool>)>> = Mutex::new(None);
    here(py)?;
    if threads > MOST_THREADS {
        let help = format!("choose at most {MOST_THREADS}; 0 is one for each core");
        return Err(error::raise(py, &format!("{threads} threads are too many"), Some(&help)));
    }
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, pool)) = last.as_ref().filter(|(n, _)| *n == threads) {
        return Ok(pool.clone());
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("eyot-{i}")).build();
    let pool = pool.map_err(|e| {
        let message = format!("cannot start {threads} threads: {e}");
        error::raise(py, &message, Some("choose fewer with `threads=`"))
    })?;
    let pool = Arc::new(pool);
    *last = Some((threads, pool.clone()));
    Ok(pool)
}

/// Fails in a process that was forked from the one that imported the package: its threads and locks are copies without an owner.
fn here(py: Python<'_>) -> PyResult<()> {
    if PROCESS.get().is_some_and(|id| *id != std::process::id()) {
        return Err(error::raise(
            py,
            "this process was forked from one that had imported eyot, whose threads it does not have",
            Some(
                "start processes anew: multiprocessing.get_context(\"spawn\") or concurrent.futures with that context",
            ),
        ));
    }
    Ok(())
}

/// What came of work, and the exception of a signal that came meanwhile.
pub(crate) struct Done<T> {
    pub(crate) result: T,
    pub(crate) signal: Option<PyErr>,
}

/// Does work on a thread of its own without Python's lock. A signal whose handler raises, as Ctrl-C does, raises `cancel`; the work
/// is waited for all the same.
///
/// # Errors
/// In a forked process, and if the work panics.
pub(crate) fn attended<T: Send>(
    py: Python<'_>,
    pool: &ThreadPool,
    cancel: Option<&Cancel>,
    work: impl FnOnce() -> T + Send,
) -> PyResult<Done<T>> {
    here(py)?;
    let (signal, result) = py.detach(|| {
        let (tell, told) = channel();
        std::thread::scope(|scope| {
            scope.spawn(move || {
                let result = catch_unwind(AssertUnwindSafe(|| pool.install(work)));
                // Whoever waits is there until it is told.
                let _ = tell.send(result);
            });
            let mut signal = None;
            let result = loop {
                match told.recv_timeout(LOOK) {
                    Ok(result) => break Some(result),
                    Err(RecvTimeoutError::Disconnected) => break None,
                    Err(RecvTimeoutError::Timeout) => {
                        if let Err(e) = Python::attach(|py| py.check_signals()) {
                            signal.get_or_insert(e);
                            cancel.inspect(|c| c.raise());
                        }
                    }
                }
            };
            (signal, result)
        })
    });
    match result {
        Some(Ok(result)) => Ok(Done { result, signal }),
        Some(Err(panic)) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("for an unknown reason");
            Err(error::fault(py, text))
        }
        None => Err(error::fault(py, "a thread ended without a result")),
    }
}

/// As [`attended`] with all cores, for work that ends by itself; a signal is raised when it has.
///
/// # Errors
/// As [`attended`], and on a signal.
pub(crate) fn free<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let done = attended(py, &*pool(py, 0)?, None, work)?;
    done.signal.map_or(Ok(done.result), Err)
}
