//! Why results could not be written or read.

use std::io;
use std::path::{Path, PathBuf};

use diffuse_contact_mesh::file::reason;
use thiserror::Error;

/// Why results could not be written or read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// A file could not be written.
    #[error("{}: cannot be written: {}", path.display(), reason(source))]
    Write {
        /// The file.
        path: PathBuf,
        /// The reason, such as a full disk.
        source: io::Error,
    },
    /// A file could not be read.
    #[error("{}: cannot be read: {}", path.display(), reason(source))]
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
    /// A file does not fit the others.
    #[error("{}: {problem}", path.display())]
    Inconsistent {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// There is a file where the directory would be.
    #[error("{} is a file: results go to a directory, such as {}.results", path.display(), path.display())]
    NoDirectory {
        /// The file.
        path: PathBuf,
    },
    /// The directory holds results already.
    #[error("{} holds results already: go on from them with --restart, or replace them with --overwrite", path.display())]
    Occupied {
        /// The directory.
        path: PathBuf,
    },
    /// The directory holds files of a run, but no state.
    #[error(
        "{} holds files of a run, but no state to go on from: replace them with --overwrite, or name another directory",
        path.display()
    )]
    Remains {
        /// The directory.
        path: PathBuf,
    },
    /// The directory holds a deck that would be replaced by another, and no results that it belongs to: none at all, or those of the deck as
    /// it was before it was changed.
    #[error(
        "{} is another deck than the one to be solved, and belongs to no results: it is not replaced, name another directory",
        path.display()
    )]
    ForeignDeck {
        /// The deck.
        path: PathBuf,
    },
    /// A folder whose files would have to be removed is a link.
    #[error(
        "{} is a link, and files that it leads to are not removed: remove the link or the files, or name another directory",
        path.display()
    )]
    Linked {
        /// The folder.
        path: PathBuf,
    },
    /// Another run writes to the directory.
    #[error("{}: another run is writing there; wait for its end, or name another directory", path.display())]
    Busy {
        /// The directory.
        path: PathBuf,
    },
    /// There is nothing to go on from.
    #[error("{} holds no results to go on from: begin without --restart", path.display())]
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
    /// The results are those of the deck beside them as it was before it was changed.
    #[error(
        "{} holds results of this deck as it was before it was changed: go on with it as it was, or replace them with --overwrite",
        path.display()
    )]
    ChangedDeck {
        /// The directory.
        path: PathBuf,
    },
    /// The results are those of the same deck, but a file that it names has changed.
    #[error(
        "{} holds results of another mesh: nodes, elements or sets in a file that the deck names are not what they were",
        path.display()
    )]
    OtherModel {
        /// The directory.
        path: PathBuf,
    },
}

impl OutputError {
    /// Whether there was no space left, on the disk or in what the user may have of it.
    #[must_use]
    pub fn is_full_disk(&self) -> bool {
        use io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
        matches!(self, Self::Write { source, .. } if matches!(source.kind(), StorageFull | QuotaExceeded | FileTooLarge))
    }

    pub(crate) fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Write { path, source }
    }

    pub(crate) fn read(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Read { path, source }
    }
}
