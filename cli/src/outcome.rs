//! What a job answers for one entry of its input, and how many have no answer.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use serde::Serialize;

use crate::error::CliError;
use crate::{input, output};

/// One entry of an output file.
#[derive(Debug, Serialize)]
#[serde(tag = "status", rename_all = "lowercase")]
pub enum Outcome<T> {
    /// The result.
    Ok(Box<T>),
    /// There is none. `code` is a stable machine-readable reason, `message` the reason in words, with its figures.
    Error { code: &'static str, message: String },
}

/// Exit code if an entry has no result.
const INCOMPLETE: u8 = 1;

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

    /// Says on standard error how many of the `total` entries, called `what`, have no result; nothing if all have. The exit code
    /// tells the two apart. `is_whole`: whether all were looked at.
    fn report(&self, total: usize, what: &str, is_whole: bool) -> ExitCode {
        if self.0.is_empty() {
            return ExitCode::SUCCESS;
        }
        let codes: Vec<String> = self.0.iter().map(|(code, count)| format!("{code}: {count}")).collect();
        let failed: usize = self.0.values().sum();
        let least = if is_whole { "" } else { "at least " };
        let codes = codes.join(", ");
        let _ = writeln!(io::stderr(), "note: {least}{failed} of {total} {what} have no result ({codes})");
        ExitCode::from(INCOMPLETE)
    }
}

/// Reads a document and writes what there is to say to it, to `target` or else standard output. Standard error and the exit code tell
/// how many of its entries, called `what`, have no result.
pub fn answer<D>(
    (source, target): (&Path, Option<&Path>),
    parse: impl FnOnce(&str, &[u8]) -> Result<D, CliError>,
    write: impl FnOnce(&mut dyn Write, &D, &mut Failures) -> io::Result<()>,
    (count, what): (impl FnOnce(&D) -> usize, &str),
) -> Result<ExitCode, CliError> {
    if let Some(path) = target {
        output::check_target(path)?;
        output::check_distinct(source, path)?;
    }
    let (file, text) = input::read(source)?;
    let document = parse(&file, &text)?;
    let mut failures = Failures::default();
    let fill = |writer: &mut dyn Write| write(writer, &document, &mut failures);
    let written = match target {
        Some(path) => output::write_file(path, fill),
        None => output::write_stdout(fill),
    };
    // Whoever reads only the beginning is told what failed so far.
    let is_whole = match written {
        Ok(()) => true,
        Err(error) if error.is_closed_pipe() => false,
        Err(error) => return Err(error),
    };
    Ok(failures.report(count(&document), what, is_whole))
}
