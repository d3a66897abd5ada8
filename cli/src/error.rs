//! Everything that ends the program, one sentence each, with the place.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};
use std::path::PathBuf;

use diffuse_contact::ElementError;
use diffuse_contact_mesh::MeshError;

/// Why the program stops. The text is the sentence the user reads after `error: `.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
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
