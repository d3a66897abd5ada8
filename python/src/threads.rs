//! The threads that evaluate.

use std::sync::Arc;

use diffuse_contact::threads::Threads;
use pyo3::prelude::*;
use rayon::ThreadPool;

use crate::errors;

static THREADS: Threads = Threads::new();

/// The pool of this process. An exception is Python's work, which may hand the GIL to a thread that waits for the pool: it is made
/// when that is free again.
fn pool(py: Python<'_>) -> PyResult<Arc<ThreadPool>> {
    THREADS.pool().map_err(|error| errors::input(py, "no-threads", &format!("there are no threads: {error}")))
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
    THREADS.set(count.unwrap_or(0));
    Ok(())
}

/// Number of threads that evaluate.
#[pyfunction]
pub fn thread_count(py: Python<'_>) -> PyResult<usize> {
    Ok(pool(py)?.current_num_threads())
}
