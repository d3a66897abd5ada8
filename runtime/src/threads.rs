//! The threads of a library inside another program.

use std::process;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// A pool of threads whose size can be set at any time and that a process has after a fork, too. Rayon's global pool can neither: its
/// threads do not survive a fork, and work that a child hands to them would never be done.
///
/// ```
/// use diffuse_contact::threads::Threads;
///
/// static THREADS: Threads = Threads::new();
/// THREADS.set(2);
/// assert_eq!(THREADS.run(rayon::current_num_threads), 2);
/// ```
#[derive(Debug)]
pub struct Threads(Mutex<State>);

#[derive(Debug)]
struct State {
    /// Number asked for; 0 for `RAYON_NUM_THREADS`, or else one per core.
    count: usize,
    /// The pool, and the process it was made in.
    pool: Option<(u32, Arc<ThreadPool>)>,
}

impl Default for Threads {
    fn default() -> Self {
        Self::new()
    }
}

impl Threads {
    /// One for each core, or as many as the environment variable `RAYON_NUM_THREADS` says. None is started yet.
    pub const fn new() -> Self {
        Self(Mutex::new(State { count: 0, pool: None }))
    }

    /// Only held for a moment, and with nothing inside that panics.
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The pool of this process.
    fn pool(&self) -> Result<Arc<ThreadPool>, ThreadPoolBuildError> {
        let mut state = self.state();
        match &state.pool {
            Some((process, pool)) if *process == process::id() => return Ok(Arc::clone(pool)),
            // The parent's: dropping it would wait for its threads.
            Some(_) => std::mem::forget(state.pool.take()),
            None => {}
        }
        let pool = Arc::new(ThreadPoolBuilder::new().num_threads(state.count).build()?);
        state.pool = Some((process::id(), Arc::clone(&pool)));
        Ok(pool)
    }

    /// Runs work that may be parallel in the pool, or where its threads cannot be started in the calling one, which belongs to a pool of
    /// its own from then on: whatever the work would hand to others it does itself.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match self.pool() {
            Ok(pool) => pool.install(work),
            Err(_) => {
                // It fails where the thread belongs to a pool already, which is that one.
                let own = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
                let _ = own.map(std::mem::forget);
                work()
            }
        }
    }

    /// How many threads do the work of [`run`](Self::run).
    pub fn count(&self) -> usize {
        self.pool().map_or(1, |pool| pool.current_num_threads())
    }

    /// Sets the number of threads; 0 for that of [`new`](Self::new). Work that runs in the pool of before ends first.
    pub fn set(&self, count: usize) {
        let before = {
            let mut state = self.state();
            state.count = count;
            state.pool.take()
        };
        match before {
            // The last to hold the pool drops it.
            Some((process, pool)) if process == process::id() => drop(pool),
            other => std::mem::forget(other),
        }
    }
}
