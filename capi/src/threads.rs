//! The threads that evaluate. Where none can be started, the calling one works alone: results are the same.

use runtime::threads::Threads;

use crate::border;
use crate::status::{DC_BAD_OPTION, Failure, dc_status};

/// The largest number of threads that may be asked for.
const MOST: i32 = 1024;

static THREADS: Threads = Threads::new();

/// Runs work that may be parallel.
pub fn run<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    THREADS.run(work)
}

/// Sets how many threads evaluate, for the whole process: 1 to 1024, or 0 for the environment variable RAYON_NUM_THREADS, or else one per
/// core. No result depends on it. Where ranks of MPI are the parallelism, 1. DC_BAD_OPTION for any other number, which changes nothing.
#[unsafe(no_mangle)]
pub extern "C" fn dc_set_threads(count: i32) -> dc_status {
    border::call(|| {
        if !(0..=MOST).contains(&count) {
            let message =
                format!("invalid-option: the number of threads must be from 0 to {MOST}, not {count}");
            return Err(Failure::new(DC_BAD_OPTION, message));
        }
        THREADS.set(count as usize);
        Ok(())
    })
}

/// How many threads evaluate: 1 where none could be started.
#[unsafe(no_mangle)]
pub extern "C" fn dc_thread_count() -> usize {
    THREADS.count()
}
