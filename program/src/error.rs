//! Everything that ends the program, one sentence each, with the place.

use std::error::Error;
use std::fmt::Display;
use std::io::{self, ErrorKind, Write};
use std::path::PathBuf;

use diffuse_contact_mesh::file::reason as reason_of;
use diffuse_contact_mesh::names::{escaped, shown};

/// Why the program stops. The text is the sentence the user reads after `error: `.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum CliError {
    #[error("{}: is the input file; give another name for the output", path.display())]
    OutputIsInput { path: PathBuf },
    #[error("{}: is to hold two results; give another name for one of them", path.display())]
    OutputIsOutput { path: PathBuf },
    #[error("{}: the output is a VTU file, for ParaView; give it a name that ends with .vtu", path.display())]
    NoGrid { path: PathBuf },
    #[error("{}: is no page, and is not replaced by one; give another name for the output", path.display())]
    NoPage { path: PathBuf },
    #[error("{}: cannot be read: {}", path.display(), reason_of(reason))]
    Read { path: PathBuf, reason: io::Error },
    /// The JSON text does not follow the schema. `file` is `standard input` if there is none; line and column count from 1.
    #[error("{file}, line {line}, column {column}: {what}")]
    Json { file: String, line: usize, column: usize, what: String },
    #[error("{}: cannot be written: {}", path.display(), reason_of(reason))]
    Write { path: PathBuf, reason: io::Error },
    #[error("{}: cannot be written: there is no directory {}", path.display(), directory.display())]
    NoDirectory { path: PathBuf, directory: PathBuf },
    #[error("standard output cannot be written: {}", reason_of(.0))]
    Stdout(io::Error),
    #[error("{option} has no meaning beside {beside}")]
    MeaninglessOption { option: &'static str, beside: &'static str },
    /// So many threads cannot be started.
    #[error("--threads {threads}: {}", plain_text(&reason.to_string()))]
    Threads { threads: usize, reason: rayon::ThreadPoolBuildError },
    #[error(
        "DIFFUSE_CONTACT_ISA: this program has no kernels for {:?} on this machine; it has {}{}",
        shown(name),
        available.join(", "),
        advice(name)
    )]
    NoInstructions { name: String, available: Vec<&'static str> },
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
    pub fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Stdout(reason) if reason.kind() == ErrorKind::BrokenPipe)
    }
}

/// How a program gets the instructions of this name.
fn advice(name: &str) -> &'static str {
    if name == "avx512" { "; those for avx512 come with the feature avx512" } else { "" }
}

/// A text that holds what the system says, without error numbers.
pub(crate) fn plain_text(text: &str) -> String {
    text.split(" (os error").next().unwrap_or(text).to_lowercase()
}

/// Prints `error: …` on standard error; if that is closed there is nobody to tell.
pub fn report(error: &dyn Display) {
    say(&format!("error: {error}"));
}

/// Prints lines on standard error, where a name from a file must not speak to the terminal.
pub fn say(lines: &str) {
    let lines: Vec<String> = lines.split('\n').map(escaped).collect();
    let _ = writeln!(io::stderr(), "{}", lines.join("\n"));
}
