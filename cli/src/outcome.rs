//! What a job answers for one entry of its input, and how many have no answer.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::Serialize;

/// One entry of an output file.
#[derive(Debug, Serialize)]
#[serde(tag = "status", rename_all = "lowercase")]
pub enum Outcome<T> {
    /// The result.
    Ok(Box<T>),
    /// There is none.
    Error {
        /// Stable machine-readable reason.
        code: &'static str,
        /// The reason in words, with its figures.
        message: String,
    },
}

/// How often each reason occurred for which there is no result.
#[derive(Debug, Default)]
pub struct Failures(BTreeMap<&'static str, usize>);

impl Failures {
    /// Counts an outcome if it is a failure.
    pub fn count<T>(&mut self, outcome: &Outcome<T>) {
        if let Outcome::Error { code, .. } = outcome {
            *self.0.entry(code).or_default() += 1;
        }
    }

    /// Says on standard error how many of the `total` entries, called `what`, have no result; nothing if all have.
    pub fn report(&self, total: usize, what: &str) {
        if self.0.is_empty() {
            return;
        }
        let codes: Vec<String> = self.0.iter().map(|(code, count)| format!("{code}: {count}")).collect();
        let failed: usize = self.0.values().sum();
        let _ =
            writeln!(io::stderr(), "note: {failed} of {total} {what} have no result ({})", codes.join(", "));
    }
}
