//! Everything that ends the program, one sentence each, with the place.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};
use std::path::PathBuf;

use diffuse_contact::ElementError;
use diffuse_contact::ad::FormulaError;
#[cfg(feature = "bench")]
use diffuse_contact_benches::MeasureError;
use diffuse_contact_codegen::model::WeightError;
use diffuse_contact_codegen::{Basis, Mode, Output};
use diffuse_contact_mesh::MeshError;
use diffuse_contact_mesh::file::reason as reason_of;
use diffuse_contact_mesh::names::{escaped, shown};
use diffuse_contact_solver::deck::DeckError;
use diffuse_contact_solver::solve::SolveError;

use crate::check::NoElement;
use crate::study::StudyError;

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
    #[error("{}: cannot be read: {}", path.display(), reason_of(reason))]
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
    /// A list of master nodes is too short for any basis.
    #[error("{file}: {place}: {found} nodes, but a surface needs at least 3")]
    TooFewMasters {
        /// The file, or `standard input`.
        file: String,
        /// The field that lists them.
        place: String,
        /// Their number.
        found: usize,
    },
    /// A field has no meaning beside another one.
    #[error("{file}: {place}: has no meaning {beside}")]
    MeaninglessField {
        /// The file, or `standard input`.
        file: String,
        /// The field.
        place: String,
        /// Beside what.
        beside: &'static str,
    },
    /// An output file cannot be written.
    #[error("{}: cannot be written: {}", path.display(), reason_of(reason))]
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
    /// A deck, its model or its results.
    #[error(transparent)]
    Solve(Box<SolveError>),
    /// Standard output cannot be written.
    #[error("standard output cannot be written: {}", reason_of(.0))]
    Stdout(io::Error),
    /// The mesh file cannot be read or is not a mesh this program knows.
    #[error(transparent)]
    Mesh(Box<MeshError>),
    /// The mesh lacks a set that was asked for.
    #[error("{mesh}: {reason}")]
    Set {
        /// The file, or the name of the shipped mesh.
        mesh: String,
        /// What the mesh says.
        reason: Box<MeshError>,
    },
    /// A set of the mesh cannot serve as contact surface.
    #[error("{mesh}: set \"{set}\": {reason}")]
    Surface {
        /// The file, or the name of the shipped mesh.
        mesh: String,
        /// The set.
        set: String,
        /// Why not.
        reason: ElementError,
    },
    /// A set of the mesh cannot serve in a contact interface.
    #[error("{mesh}: set \"{set}\": {reason}")]
    Interface {
        /// The file.
        mesh: String,
        /// The set.
        set: String,
        /// Why not, with facets and nodes named as in the file.
        reason: String,
    },
    /// An option has no meaning beside another one.
    #[error("{option} has no meaning beside {beside}")]
    MeaninglessOption {
        /// The option.
        option: &'static str,
        /// Beside what.
        beside: &'static str,
    },
    /// So many threads cannot be started.
    #[error("--threads {threads}: {}", plain_text(&reason.to_string()))]
    Threads {
        /// What was asked for.
        threads: usize,
        /// What the system says.
        reason: rayon::ThreadPoolBuildError,
    },
    /// The environment asks for vector instructions that there are not.
    #[error("DIFFUSE_CONTACT_ISA: this machine has no instructions {:?}; it has {}", shown(name), available.join(", "))]
    NoInstructions {
        /// What was asked for.
        name: String,
        /// What there is.
        available: Vec<&'static str>,
    },
    /// A deck that a study solves is not there.
    #[error(
        "{0}; it is one of the repository's: run the study at the root of the repository, or name the directory with --decks"
    )]
    NoStudyDeck(Box<SolveError>),
    /// A study cannot be made.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A formula is no weight. If it cannot be read, the formula itself follows below the sentence, with a mark.
    #[error("--weight: {0}")]
    Weight(#[from] WeightError),
    /// The AD backend, which has a parser of its own, does not take a formula that the generator takes.
    #[error("--weight: automatic differentiation cannot use \"{formula}\": {reason}")]
    WeightOfAd {
        /// The formula.
        formula: String,
        /// What the backend says.
        reason: FormulaError,
    },
    /// Fewer nodes were asked for than the fit has coefficients.
    #[error("--nodes {nodes}: the {} basis needs at least {} master nodes", basis.name(), basis.size())]
    TooFewNodes {
        /// What was asked for.
        nodes: String,
        /// The basis.
        basis: Basis,
    },
    /// A moving frame was asked for where it makes no difference.
    #[error(
        "--frame-derivative co-moving: there is no such kernel for {} {}, only for the gap",
        output.name(),
        mode.name()
    )]
    NoMovingFrame {
        /// What is computed.
        output: Output,
        /// With how many derivatives.
        mode: Mode,
    },
    /// Nothing can be measured, or a contender computes something else.
    #[cfg(feature = "bench")]
    #[error(transparent)]
    Measure(#[from] MeasureError),
    /// The program was built without what `bench` measures.
    #[cfg(not(feature = "bench"))]
    #[error("this program was built without it: cargo run --profile bench -- bench")]
    NoBench,
    /// There is nothing to compare on.
    #[error(transparent)]
    NoElement(#[from] NoElement),
}

impl CliError {
    /// Whether the reader of standard output has gone away.
    pub fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Stdout(reason) if reason.kind() == ErrorKind::BrokenPipe)
    }

    /// The error of a study: if it lacks a deck of the repository it says where there is one.
    pub fn of_study(self) -> Self {
        match self {
            Self::Solve(reason) if matches!(&*reason, SolveError::Deck(DeckError::Read { .. })) => {
                Self::NoStudyDeck(reason)
            }
            other => other,
        }
    }
}

/// A text that holds what the system says, without error numbers.
pub fn plain_text(text: &str) -> String {
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
