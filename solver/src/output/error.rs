//! Why results could not be written or read.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why results could not be written or read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// A file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The reason, such as a full disk.
        source: io::Error,
    },
    /// A file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: io::Error,
    },
    /// A file holds something else.
    #[error("{}, line {line}: {problem}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        problem: String,
    },
    /// The directory holds results already.
    #[error("{} holds results already: go on from them with --restart, or replace them with --overwrite", path.display())]
    Occupied {
        /// The directory.
        path: PathBuf,
    },
    /// There is nothing to go on from.
    #[error("{} holds no finished increment to go on from", path.display())]
    NothingToRestart {
        /// The directory.
        path: PathBuf,
    },
    /// The results are those of another deck.
    #[error("{} holds results of another deck: it differs from line {line} on", path.display())]
    OtherDeck {
        /// The directory.
        path: PathBuf,
        /// First line that differs, from 1.
        line: usize,
    },
}

impl OutputError {
    pub(crate) fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Write { path, source }
    }

    pub(crate) fn read(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Read { path, source }
    }
}
