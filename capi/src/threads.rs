//! The threads that evaluate.
//!
//! The pool is ours and not rayon's global one: its size can be set, and after a fork the child gets a new one. A pool's threads do not
//! survive a fork, and work that a child hands to them would never be done. Where no thread can be started, the calling one works alone:
//! results are the same.

use std::process;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::border;
use crate::status::{DC_BAD_OPTION, Failure, dc_status};

/// The largest number of threads that may be asked for.
const MOST: i32 = 1024;

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

/// The pool of this process, if its threads can be started.
fn pool() -> Option<Arc<ThreadPool>> {
    let mut threads = threads();
    match &threads.pool {
        Some((process, pool)) if *process == process::id() => return Some(Arc::clone(pool)),
        // The parent's: dropping it would wait for its threads.
        Some(_) => std::mem::forget(threads.pool.take()),
        None => {}
    }
    let pool = Arc::new(ThreadPoolBuilder::new().num_threads(threads.count).build().ok()?);
    threads.pool = Some((process::id(), Arc::clone(&pool)));
    Some(pool)
}

/// Runs work in the calling thread, which belongs to a pool of its own from then on: whatever the work would hand to others it does
/// itself.
fn alone<T>(work: impl FnOnce() -> T) -> T {
    // It fails where the thread belongs to a pool already, which is that one.
    let _ = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().map(std::mem::forget);
    work()
}

/// Runs work that may be parallel.
pub fn run<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    Ok(match pool() {
        Some(pool) => pool.install(work),
        None => alone(work),
    })
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
        let before = {
            let mut threads = threads();
            threads.count = count as usize;
            threads.pool.take()
        };
        match before {
            // Work that still runs in it ends first; the last to hold the pool drops it.
            Some((process, pool)) if process == process::id() => drop(pool),
            other => std::mem::forget(other),
        }
        Ok(())
    })
}

/// How many threads evaluate: 1 where none could be started.
#[unsafe(no_mangle)]
pub extern "C" fn dc_thread_count() -> usize {
    pool().map_or(1, |pool| pool.current_num_threads())
}
