//! Showing that something happens.

use std::io::{IsTerminal, Write, stderr};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Between two lines of a log.
const PAUSE: Duration = Duration::from_secs(10);

/// How far a piece of work is.
#[derive(Debug)]
pub enum Progress {
    /// A bar on a terminal.
    Bar(ProgressBar),
    /// A line from time to time in a log; none of what is done before the first is due.
    Log(Log),
}

/// Lines in a log.
#[derive(Debug)]
pub struct Log {
    what: &'static str,
    length: usize,
    done: AtomicUsize,
    last: Mutex<Instant>,
}

/// A bar on a terminal, a line from time to time in a log: for what takes minutes.
pub fn logged(what: &'static str, length: usize) -> Progress {
    if stderr().is_terminal() {
        return progress(what, length);
    }
    Progress::Log(Log { what, length, done: AtomicUsize::new(0), last: Mutex::new(Instant::now()) })
}

/// A bar on a terminal, nothing in a log.
pub fn progress(what: &'static str, length: usize) -> Progress {
    if !stderr().is_terminal() {
        return Progress::Bar(ProgressBar::hidden());
    }
    let style = ProgressStyle::with_template("{msg:>24} {wide_bar} {pos}/{len}");
    let bar = ProgressBar::new(length as u64)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_message(what);
    Progress::Bar(bar)
}

impl Progress {
    /// So many more are done.
    pub fn inc(&self, count: u64) {
        match self {
            Self::Bar(bar) => bar.inc(count),
            Self::Log(log) => {
                if let Some(line) = log.step(count as usize, PAUSE) {
                    let _ = writeln!(stderr(), "{line}");
                }
            }
        }
    }

    /// It is over.
    pub fn finish_and_clear(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

impl Log {
    /// The line that is due, if one is. Whoever finds another thread at it leaves it to that one.
    fn step(&self, count: usize, pause: Duration) -> Option<String> {
        let done = self.done.fetch_add(count, Ordering::Relaxed) + count;
        let mut last = self.last.try_lock().ok()?;
        if last.elapsed() < pause {
            return None;
        }
        *last = Instant::now();
        Some(format!("{}: {done} of {}", self.what, self.length))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_has_a_line_from_time_to_time() {
        let log =
            Log { what: "steps", length: 5, done: AtomicUsize::new(0), last: Mutex::new(Instant::now()) };
        assert_eq!(log.step(2, PAUSE), None);
        assert_eq!(log.step(1, Duration::ZERO).as_deref(), Some("steps: 3 of 5"));
        assert_eq!(log.step(1, PAUSE), None);
    }
}
