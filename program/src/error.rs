//! Everything that ends the program, one sentence each, with the place.

use std::error::Error;
use std::fmt::Display;
use std::io::{self, ErrorKind, Write};
use std::path::PathBuf;

/// Why the program stops. The text is the sentence the user reads after `error: `.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// The output file is the input file.
    #[error("{}: is the input file; give another name for the output", path.display())]
    OutputIsInput {
        /// The file.
        path: PathBuf,
    },
    /// An input file cannot be read.
    #[error("{}: cannot be read: {}", path.display(), plain(reason))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
    /// The JSON text does not follow the schema.
    #[error("{file}, line {line}, column {column}: {what}")]
    Json {
        /// The file, or `standard input`.
        file: String,
        /// Line, counted from 1.
        line: usize,
        /// Column, counted from 1.
        column: usize,
        /// The field, if it is known, and what is wrong with it.
        what: String,
    },
    /// An output file cannot be written.
    #[error("{}: cannot be written: {}", path.display(), plain(reason))]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
    /// The directory of an output file does not exist.
    #[error("{}: cannot be written: there is no directory {}", path.display(), directory.display())]
    NoDirectory {
        /// The file.
        path: PathBuf,
        /// Its directory.
        directory: PathBuf,
    },
    /// Standard output cannot be written.
    #[error("standard output cannot be written: {}", plain(.0))]
    Stdout(io::Error),
    /// An option has no meaning beside another one.
    #[error("{option} has no meaning beside {beside}")]
    MeaninglessOption {
        /// The option.
        option: &'static str,
        /// Beside what.
        beside: &'static str,
    },
    /// So many threads cannot be started.
    #[error("--threads {threads}: {reason}")]
    Threads {
        /// What was asked for.
        threads: usize,
        /// What the system says.
        reason: rayon::ThreadPoolBuildError,
    },
    /// What the job itself says.
    #[error(transparent)]
    Job(Box<dyn Error + Send + Sync>),
}

impl CliError {
    /// An error of one job, whose text is a sentence, too.
    pub fn job(reason: impl Error + Send + Sync + 'static) -> Self {
        Self::Job(Box::new(reason))
    }

    /// Whether the reader of standard output has gone away.
    #[must_use]
    pub fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Stdout(reason) if reason.kind() == ErrorKind::BrokenPipe)
    }
}

/// What the system says, without error numbers.
fn plain(reason: &io::Error) -> String {
    match reason.kind() {
        ErrorKind::NotFound => "there is no such file".into(),
        ErrorKind::PermissionDenied => "permission denied".into(),
        ErrorKind::IsADirectory => "it is a directory".into(),
        ErrorKind::NotADirectory => "part of its path is not a directory".into(),
        _ => {
            let text = reason.to_string();
            text.split(" (os error").next().unwrap_or(&text).to_lowercase()
        }
    }
}

/// Prints `error: …` on standard error; if that is closed there is nobody to tell.
pub fn report(error: &dyn Display) {
    let _ = writeln!(io::stderr(), "error: {error}");
}
