//! The threads that evaluate. Where none can be started, the calling one works alone: results are the same.

use diffuse_contact::threads::Threads;
use pyo3::prelude::*;

use crate::errors::{self, Raise};

static THREADS: Threads = Threads::new();

/// Runs work that may be parallel, without the GIL.
pub fn run<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
    py.detach(|| THREADS.run(work))
}

/// The same for work that may be refused. The exception is made behind it, with the GIL.
pub fn attempt<T: Send, E: Raise + Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, E> + Send,
) -> PyResult<T> {
    run(py, work).map_err(|error| error.raise(py))
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

/// Number of threads that evaluate: 1 where none could be started.
#[pyfunction]
pub fn thread_count() -> usize {
    THREADS.count()
}
