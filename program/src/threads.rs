//! Working with a given number of threads.

use crate::error::CliError;

/// Threads of the machine beyond which more of them cannot be meant.
const MOST: usize = 1024;

/// Does `work` with so many threads; with as many as the machine has if none are named.
pub fn with_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, CliError> + Send,
) -> Result<T, CliError> {
    let Some(threads) = threads else { return work() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|reason| CliError::Threads { threads, reason })?.install(work)
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
