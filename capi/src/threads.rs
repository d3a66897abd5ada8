//! The threads that evaluate.
//!
//! They are rayon's, shared by the whole process. They do not survive a fork: work that a child hands to them would never be done. So a
//! child gets a pool of its own.

use std::process;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::status::{DC_TOO_LARGE, Failure};

/// The process that handed out work first, and so started rayon's threads.
static FIRST: OnceLock<u32> = OnceLock::new();

/// A pool, and the process it was made in.
static CHILD: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Runs work that may be parallel.
pub fn run<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    let process = process::id();
    if *FIRST.get_or_init(|| process) == process {
        return Ok(work());
    }
    let mut child = CHILD.lock().unwrap_or_else(PoisonError::into_inner);
    let pool = match &*child {
        Some((owner, pool)) if *owner == process => Arc::clone(pool),
        _ => {
            // The parent's: dropping it would wait for its threads.
            std::mem::forget(child.take());
            let made = ThreadPoolBuilder::new().build();
            let pool =
                Arc::new(made.map_err(|error| {
                    Failure::new(DC_TOO_LARGE, format!("no-threads: after a fork: {error}"))
                })?);
            *child = Some((process, Arc::clone(&pool)));
            pool
        }
    };
    drop(child);
    Ok(pool.install(work))
}
