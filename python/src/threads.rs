//! The threads that evaluate.
//!
//! The pool is ours and not rayon's global one, for two reasons: its size can be set from Python, and after a fork
//! (`multiprocessing`) the child gets a new one. A pool's threads do not survive a fork, and work handed to them would
//! never end.

use std::process;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use crate::errors;

struct Threads {
    /// Number asked for; 0 for `RAYON_NUM_THREADS`, or else one per core.
    count: usize,
    /// The pool, and the process it was made in.
    pool: Option<(u32, Arc<ThreadPool>)>,
}

static THREADS: Mutex<Threads> = Mutex::new(Threads { count: 0, pool: None });

/// Only held for a moment, and with nothing inside that panics.
fn threads() -> MutexGuard<'static, Threads> {
    THREADS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The pool of this process. An exception is Python's work, which may hand the GIL to a thread that waits for the lock: it is made
/// when the lock is free again.
fn pool(py: Python<'_>) -> PyResult<Arc<ThreadPool>> {
    made_pool().map_err(|error| errors::input(py, "no-threads", &format!("there are no threads: {error}")))
}

fn made_pool() -> Result<Arc<ThreadPool>, ThreadPoolBuildError> {
    let mut threads = threads();
    match &threads.pool {
        Some((process, pool)) if *process == process::id() => return Ok(Arc::clone(pool)),
        // The parent's: dropping it would wait for its threads.
        Some(_) => std::mem::forget(threads.pool.take()),
        None => {}
    }
    let pool = Arc::new(ThreadPoolBuilder::new().num_threads(threads.count).build()?);
    threads.pool = Some((process::id(), Arc::clone(&pool)));
    Ok(pool)
}

/// Runs `work` in the pool, without the GIL.
pub fn run<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = pool(py)?;
    Ok(py.detach(|| pool.install(work)))
}

/// Sets the number of threads; `None` for the environment variable `RAYON_NUM_THREADS`, or else one per core.
#[pyfunction]
pub fn set_threads(py: Python<'_>, count: Option<usize>) -> PyResult<()> {
    if count.is_some_and(|count| !(1..=1024).contains(&count)) {
        return Err(errors::input(py, "invalid-option", "the number of threads must be from 1 to 1024"));
    }
    let before = {
        let mut threads = threads();
        threads.count = count.unwrap_or(0);
        threads.pool.take()
    };
    match before {
        // Work that still runs in it ends first; the last to hold the pool drops it.
        Some((process, pool)) if process == process::id() => drop(pool),
        other => std::mem::forget(other),
    }
    Ok(())
}

/// Number of threads that evaluate.
#[pyfunction]
pub fn thread_count(py: Python<'_>) -> PyResult<usize> {
    Ok(pool(py)?.current_num_threads())
}
