//! The threads that evaluate.
//!
//! They are rayon's, shared by the whole process. They do not survive a fork: work that a child hands to them would never be done. So a
//! child gets a pool of its own. Where no thread can be started, the calling one works alone: results are the same.

use std::error::Error;
use std::process;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use crate::status::Failure;

/// The process that handed out work first, and so started rayon's threads.
static FIRST: OnceLock<u32> = OnceLock::new();

/// A pool, and the process it was made in.
static CHILD: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Whether rayon's threads, which work is shared among unless a pool says otherwise, could be started.
static STARTED: OnceLock<bool> = OnceLock::new();

/// Whether the system refused threads; otherwise there is a pool already.
fn is_refused(reason: &ThreadPoolBuildError) -> bool {
    reason.source().is_some()
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
    let process = process::id();
    if *FIRST.get_or_init(|| process) == process {
        let started = *STARTED.get_or_init(|| {
            !ThreadPoolBuilder::new().build_global().is_err_and(|reason| is_refused(&reason))
        });
        return Ok(if started { work() } else { alone(work) });
    }
    let mut child = CHILD.lock().unwrap_or_else(PoisonError::into_inner);
    let pool = match &*child {
        Some((owner, pool)) if *owner == process => Arc::clone(pool),
        _ => {
            // The parent's: dropping it would wait for its threads.
            std::mem::forget(child.take());
            let Ok(made) = ThreadPoolBuilder::new().build() else {
                drop(child);
                return Ok(alone(work));
            };
            let pool = Arc::new(made);
            *child = Some((process, Arc::clone(&pool)));
            pool
        }
    };
    drop(child);
    Ok(pool.install(work))
}
