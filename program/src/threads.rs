//! Working with a given number of threads.

use std::error::Error;
use std::io::{self, Write};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use crate::error::{CliError, plain_text};

/// Threads of the machine beyond which more of them cannot be meant.
const MOST: usize = 1024;

/// Starts the threads of all jobs that name none. If they cannot be started, this thread works alone.
pub fn start() {
    let Err(reason) = ThreadPoolBuilder::new().build_global() else { return };
    // Without a cause of the system they are there already.
    if reason.source().is_none() {
        return;
    }
    let _ = writeln!(
        io::stderr(),
        "note: no threads can be started ({}): one thread does the work",
        plain_text(&reason.to_string())
    );
    // From here on this thread is the pool: whatever would be handed to others it does itself.
    let _ = pool_of_this_thread().map(std::mem::forget);
}

fn pool_of_this_thread() -> Result<ThreadPool, ThreadPoolBuildError> {
    ThreadPoolBuilder::new().num_threads(1).use_current_thread().build()
}

/// Does `work` with so many threads; with as many as the machine has if none are named.
pub fn with_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, CliError> + Send,
) -> Result<T, CliError> {
    let Some(threads) = threads else { return work() };
    match ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        // This thread is one.
        Err(_) if threads == 1 => {
            pool_of_this_thread()
                .map(std::mem::forget)
                .map_err(|reason| CliError::Threads { threads, reason })?;
            work()
        }
        Err(reason) => Err(CliError::Threads { threads, reason }),
    }
}

/// A number of threads on the command line.
///
/// # Errors
/// If it is not one from 1 to 1024.
pub fn parse(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(threads) if (1..=MOST).contains(&threads) => Ok(threads),
        _ => Err(format!("not a whole number from 1 to {MOST}")),
    }
}
